/* stack_make.h - the table of common/trace/stack.h, made anew by quadrature.
 * SPDX-License-Identifier: MIT */
#ifndef TESTS_STACK_MAKE_H
#define TESTS_STACK_MAKE_H

#include "common/trace/stack.h"

/* The entries of all cells. */
void stack_make_row(enum stack_lobe, int width, int cosine, uint16_t row[STACK_CELLS]);

#endif
