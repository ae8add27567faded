"""People in pictures of depth cameras, without a click.

    picture = depth_picture(number, xyz, rgb, eye, T_room_local, pitch, options.columns)
    people = find_persons(picture, PersonModel().probability, options)

Surfaces of the size of people are found first; the model then looks at each of them.
"""
