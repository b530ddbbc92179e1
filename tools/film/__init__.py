"""Films a simulated leg: pictures of coloured markers as a consumer's camera takes them, with the truth kept apart.

    from film.camera import Camera
    from film.scene import Scene
    from film.pictures import Film

    film = Film(Camera(), Scene.leg(t_s, shank_rad, foot_rad), seed=1)
    picture, truth = film.take(0.25)

`python -m film --help` makes a video. Nothing here is shared with the tracker: angles, projection and lens are
written anew.
"""
