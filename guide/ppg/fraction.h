/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_FRACTION_H
#define FEWRAY_GUIDE_FRACTION_H

/* The fraction of samples drawn from the BSDF instead of the guide, learnt by stochastic gradient
 * descent (Mueller 2019, "Practical Path Guiding in Production", learned BSDF sampling fraction;
 * the gradient of the Kullback-Leibler divergence as in Mueller et al. 2018, "Neural Importance
 * Sampling").
 */

#include <math.h>

#define FRACTION_RATE       0.01 /* Adam: Kingma and Ba 2015, with their other constants */
#define FRACTION_REGULARIZE 0.01 /* L2, keeps the fraction off 0 and 1 */
#define FRACTION_LIMIT      20.0

struct fraction {
    double variable;       /* the fraction is the logistic function of it */
    double mean, square;   /* Adam's moments of the gradient */
    double decay1, decay2; /* beta1^steps, beta2^steps; 1 at the start */
};

#define FRACTION_START                                                                             \
    { 0, 0, 0, 1, 1 } /* a half */

static inline float fraction_value(const struct fraction *f) {
    return (float)(1 / (1 + exp(-f->variable)));
}

/* One step down the Kullback-Leibler divergence of the mixture from the integrand f cos L.
 * contribution: f cos L / pdf of the sample as drawn, channels averaged; the others are densities
 * (solid angle) of its direction. */
static inline void fraction_learn(struct fraction *f, double contribution, double bsdf_pdf,
                                  double guide_pdf) {
    double a = 1 / (1 + exp(-f->variable));
    double mixture = a * bsdf_pdf + (1 - a) * guide_pdf;
    if (!(mixture > 0))
        return;
    double gradient = -contribution * (bsdf_pdf - guide_pdf) / mixture * a * (1 - a) +
                      FRACTION_REGULARIZE * f->variable;
    const double beta1 = 0.9, beta2 = 0.999;
    f->decay1 *= beta1;
    f->decay2 *= beta2;
    f->mean += (1 - beta1) * (gradient - f->mean);
    f->square += (1 - beta2) * (gradient * gradient - f->square);
    f->variable -=
        FRACTION_RATE * (f->mean / (1 - f->decay1)) / (sqrt(f->square / (1 - f->decay2)) + 1e-8);
    f->variable = fmin(fmax(f->variable, -FRACTION_LIMIT), FRACTION_LIMIT);
}

#endif
