"""Label by example: points that a person labelled teach a forest, which labels the others.

    place = describe(ExampleFrame(xyz, rgb), Scales.of(xyz))
    model = learn(features, classes)
    chance = smoothed(place, probabilities(model, place.features))

A frame becomes cells; each has numbers about its surroundings that hold anywhere (``features``).
Trees learn them from some cells (``forest``), and tell where an answer would teach most
(``doubt``).
"""
