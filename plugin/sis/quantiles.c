/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Quantiles of many intervals in little memory: a histogram with 32 buckets for each doubling. */

#include "sis/quantiles.h"

void
sis_quantiles_init(sis_quantiles_t *quantiles)
{
    memset(quantiles, 0, sizeof *quantiles);
    quantiles->p50.percent = 50;
    quantiles->p99.percent = 99;
}

/* Below 32 ns a bucket is 1 ns; above, the five bits after the first one select the bucket. */
static unsigned
bucket_of(uint32_t ns)
{
    int octave = g_bit_nth_msf(ns, -1) - 5;

    if (octave < 0)
        return ns;
    return (unsigned)(octave + 1) * SIS_BUCKETS_PER_OCTAVE + (ns >> octave) - SIS_BUCKETS_PER_OCTAVE;
}

static uint32_t
end_of_bucket(unsigned bucket)
{
    unsigned octave = bucket / SIS_BUCKETS_PER_OCTAVE, rest = bucket % SIS_BUCKETS_PER_OCTAVE;

    if (octave == 0)
        return bucket;
    return (uint32_t)((((uint64_t)rest + SIS_BUCKETS_PER_OCTAVE + 1) << (octave - 1)) - 1);
}

static void
move(sis_quantile_t *quantile, const sis_quantiles_t *quantiles, unsigned bucket)
{
    uint64_t wanted = (quantile->percent * quantiles->count + 99) / 100;

    if (bucket < quantile->bucket)
        quantile->below++;
    while (quantile->below >= wanted)
        quantile->below -= quantiles->counts[--quantile->bucket];
    while (quantile->below + quantiles->counts[quantile->bucket] < wanted)
        quantile->below += quantiles->counts[quantile->bucket++];
}

void
sis_quantiles_add(sis_quantiles_t *quantiles, uint32_t ns)
{
    unsigned bucket = bucket_of(ns);

    quantiles->counts[bucket]++;
    quantiles->count++;
    quantiles->largest = MAX(quantiles->largest, ns);
    move(&quantiles->p50, quantiles, bucket);
    move(&quantiles->p99, quantiles, bucket);
}

uint32_t
sis_quantile_ns(const sis_quantiles_t *quantiles, const sis_quantile_t *quantile)
{
    return MIN(end_of_bucket(quantile->bucket), quantiles->largest);
}
