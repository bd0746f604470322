/* SPDX-License-Identifier: Apache-2.0 */
/* Decimal numbers of scene and mesh files. */

#include "guide/scene/number.h"

#include <float.h>
#include <math.h>

static bool is_digit(char c) {
    return c >= '0' && c <= '9';
}

static bool is_separator(char c) {
    return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == ',';
}

/* mantissa * 10^exponent. Powers up to 10^22 are exact in a double, so common numbers are rounded
 * once. */
static double scale_decimal(uint64_t mantissa, int exponent) {
    static const double powers[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                    1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                    1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
    double value = (double)mantissa;
    if (mantissa == 0)
        return 0;
    if (exponent > 400)
        return INFINITY;
    if (exponent < -400)
        return 0;
    for (; exponent > 22; exponent -= 22)
        value *= powers[22];
    for (; exponent < -22; exponent += 22)
        value /= powers[22];
    return exponent < 0 ? value / powers[-exponent] : value * powers[exponent];
}

/* Reads "e-12" into *exponent; text that isn't an exponent stays where it is. */
static void read_exponent(const char **cursor, int *exponent) {
    const char *c = *cursor;
    if (*c != 'e' && *c != 'E')
        return;
    c++;
    bool negative = *c == '-';
    if (*c == '-' || *c == '+')
        c++;
    if (!is_digit(*c))
        return;
    int value = 0;
    for (; is_digit(*c); c++)
        value = value < 10000 ? value * 10 + (*c - '0') : value;
    *exponent += negative ? -value : value;
    *cursor = c;
}

bool number_read(const char **cursor, double *out) {
    const char *c = *cursor;
    bool negative = *c == '-';
    if (*c == '-' || *c == '+')
        c++;

    uint64_t mantissa = 0;
    int exponent = 0;
    bool any = false;
    /* 18 digits fit the mantissa; what follows is below a float's precision and only counts as a
     * power of ten. */
    const uint64_t full = 100000000000000000u;
    for (; is_digit(*c); c++, any = true) {
        if (mantissa < full)
            mantissa = mantissa * 10 + (uint64_t)(*c - '0');
        else if (exponent < 10000)
            exponent++;
    }
    if (*c == '.') {
        c++;
        for (; is_digit(*c); c++, any = true) {
            if (mantissa < full) {
                mantissa = mantissa * 10 + (uint64_t)(*c - '0');
                exponent = exponent > -10000 ? exponent - 1 : exponent;
            }
        }
    }
    if (!any)
        return false;
    read_exponent(&c, &exponent);
    double value = scale_decimal(mantissa, exponent);
    *out = negative ? -value : value;
    *cursor = c;
    return true;
}

bool number_read_integer(const char **cursor, int64_t *out) {
    const char *c = *cursor;
    bool negative = *c == '-';
    if (*c == '-' || *c == '+')
        c++;
    if (!is_digit(*c))
        return false;
    int64_t value = 0;
    for (; is_digit(*c); c++) {
        value = value * 10 + (*c - '0');
        if (value > (INT64_C(1) << 53))
            return false;
    }
    *out = negative ? -value : value;
    *cursor = c;
    return true;
}

int number_read_list(const char *text, double *out, int max) {
    int count = 0;
    const char *c = text;
    for (;;) {
        while (is_separator(*c))
            c++;
        if (!*c)
            return count;
        double value;
        if (count == max || !number_read(&c, &value) || !(fabs(value) <= FLT_MAX))
            return -1;
        if (*c && !is_separator(*c))
            return -1;
        out[count++] = value;
    }
}
