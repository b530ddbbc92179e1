"""talus-import: files that people have become recordings of docs/recording.md.

    table.py       a file's columns, whatever its format, with what it is unsure of
    delimited.py   text: encoding, separator, decimal sign, header, units' row
    formats.py     MATLAB, Parquet, HDF5, rosbag2, MCAP and ASAM MDF: optional readers
    asam.py        the channels of an MDF file, clock by clock
    headers.py     name and unit of a header; units through pint
    clock.py       times without loss: ns, ms-rounded, Unix, dates; order and repeats
    vocabulary.py  which words name which quantity
    guess.py       units, wraps and signs from values
    suggest.py     the map drafted from names, units and ranges
    mapping.py     the map as YAML and as --map
    assemble.py    the columns on one time base
    command.py     the command line
"""
