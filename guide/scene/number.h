/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_SCENE_NUMBER_H
#define FEWRAY_GUIDE_SCENE_NUMBER_H

/* Decimal numbers of scene and mesh files: independent of the locale, and several times as fast as
 * strtod(). */

#include <stdbool.h>
#include <stdint.h>

/* Reads a decimal number at *cursor (sign, digits, point, exponent; no blanks before it) and moves
 * *cursor behind it. False, and *cursor stays, where there is none. Within 1 ulp of a float; never
 * NaN, but infinite where the exponent is too large. The text must end with a byte that can't be
 * part of a number (a NUL will do). */
bool number_read(const char **cursor, double *out);

/* The same for a whole number, refused outside -2^53..2^53. */
bool number_read_integer(const char **cursor, int64_t *out);

/* Reads up to max numbers, separated by blanks or commas, from all of text. Returns how many; -1
 * where something else than finite floats stands in text, or more than max. */
int number_read_list(const char *text, double *out, int max);

#endif
