/* thinfilm.h - a transparent film on metal, so thin that light reflected by its two faces
 * interferes: lacquer and oxide whose colour changes with the angle.
 *
 * Airy's sum of all reflections between the faces (M. Born, E. Wolf, "Principles of Optics",
 * section 7.6), at 24 wavelengths from 400 to 700 nm, even in 1 / wavelength, each weighted by what
 * its light adds to the three channels: the colour matching functions of C. Wyman, P. Sloan, P.
 * Shirley, "Simple Analytic Approximations to the CIE XYZ Color Matching Functions", JCGT 2(2),
 * 2013, through the matrix of Rec. 709, so that equal shares of all wavelengths are white. Pure
 * spectral colours lie outside of Rec. 709; what would be below 0 or above 1 is cut. The metal's
 * constants are those of the channel at all wavelengths.
 *
 * A thickness of 0 is the bare metal.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_THINFILM_H
#define COMMON_TRACE_THINFILM_H

#include "common/scene.h"

enum { THINFILM_WAVELENGTHS = 24 };

/* By channel; those of a channel add up to 1. Wavelength i is 1 / (a + (b - a) (i + .5) / 24) nm,
 * with a = 1 / 700, b = 1 / 400. */
extern const float thinfilm_weight[3][THINFILM_WAVELENGTHS];

/* What is reflected; cos in [0, 1], the film's ior above 1. */
rgb thinfilm_metal(float cos, rgb eta, rgb k, const struct thin_film *);

#endif
