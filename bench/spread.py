"""spread.py - how noisy a renderer is, and whether two show the same picture, from several images of each.

The images of a renderer differ by their seed alone: K independent estimates. Their mean is its reference, of K times
as many samples. An image is a list of three planes, as exr.read gives them.
SPDX-License-Identifier: MIT
"""

import array
import math
import statistics


def mean(images):
    return [array.array("d", (sum(values) / len(images) for values in zip(*planes))) for planes in zip(*images)]


def _relmse(image, total, others):
    """relMSE (client/diff.h) of the image against the mean of the others."""
    everything = sum(map(sum, total)) - sum(map(sum, image))
    e = 0.01 * everything / others / sum(map(len, image))
    terms = 0
    for plane, whole in zip(image, total):
        for x, all_x in zip(plane, whole):
            y = (all_x - x) / others
            if x != y:
                terms += (x - y) * (x - y) / (y * y + e * e)
    return terms / sum(map(len, image))


def relmse(images):
    """The expected relMSE of one image against the limit, and its standard error.

    Each image is held against the mean of the others: were it in the reference itself, its brightest errors would
    excuse themselves. That mean is K - 1 times less noisy than an image, which the factor takes out."""
    others = len(images) - 1
    total = [array.array("d", map(sum, zip(*planes))) for planes in zip(*images)]
    errors = [_relmse(image, total, others) * others / len(images) for image in images]
    return statistics.mean(errors), statistics.stdev(errors) / math.sqrt(len(errors))


def blocks(image, width, side):
    """Mean of R, G and B over squares of that side, row by row."""
    height = len(image[0]) // width
    gray = [a + b + c for a, b, c in zip(*image)]
    return [sum(sum(gray[y * width + left:y * width + left + side]) for y in range(top, top + side))
            / (3 * side * side) for top in range(0, height, side) for left in range(0, width, side)]


def _mean_and_error(images, width, side):
    by_block = zip(*(blocks(image, width, side) for image in images))
    return [(statistics.mean(values), statistics.stdev(values) / math.sqrt(len(values))) for values in by_block]


def differences(ours, theirs, width, side):
    """Per block: (our mean, their mean, standard error of the difference)."""
    return [(a, b, math.hypot(s, t)) for (a, s), (b, t) in
            zip(_mean_and_error(ours, width, side), _mean_and_error(theirs, width, side))]
