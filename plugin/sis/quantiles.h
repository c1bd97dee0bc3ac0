/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Quantiles of many intervals in little memory. */

#ifndef SIS_QUANTILES_H
#define SIS_QUANTILES_H

#include "compat.h"

#define SIS_BUCKETS_PER_OCTAVE 32 /* so a quantile is at most 3 % too large */
#define SIS_BUCKETS            (SIS_BUCKETS_PER_OCTAVE * 28)

/* The bucket of one quantile. Each value moves it by a few buckets at most. */
typedef struct {
    unsigned percent; /* share of the values that are not larger */
    unsigned bucket;
    uint64_t below; /* values in the buckets before */
} sis_quantile_t;

typedef struct {
    uint64_t count;
    uint32_t largest;
    uint32_t counts[SIS_BUCKETS];
    sis_quantile_t p50, p99;
} sis_quantiles_t;

void sis_quantiles_init(sis_quantiles_t *quantiles);

/* Takes an interval, in ns. */
void sis_quantiles_add(sis_quantiles_t *quantiles, uint32_t ns);

/* In ns; rather too large than too small. 0 without values. */
uint32_t sis_quantile_ns(const sis_quantiles_t *quantiles, const sis_quantile_t *quantile);

#endif
