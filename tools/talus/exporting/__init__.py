"""talus-export to simulators: an identified model as MJCF, URDF, SDF, BAM's JSON or an Isaac Lab configuration, with a report of what each cannot hold.

    chain.py     the model as rigid links and joints
    terms.py     effects as sums of what simulators know of a joint
    target.py    what a target holds, and how a model is fitted into it
    loss.py      each effect's torque along a motion, and what is left of it
    mjcf.py urdf.py sdf.py bam.py isaac.py mcap.py    the files
    command.py   the command line
"""
