/* SPDX-License-Identifier: BSD-3-Clause */
/* Prints how far the surfaces of a volume are from those of its truth. */
#include "against.h"

#include <stdlib.h>
#include <string.h>

/* Tissues of at least so much volume and thickness in the truth are large: they are summed up in
 * one row. */
#define LARGE_MM3 5000.0
#define LARGE_MM 3.0

/* What is printed of one tissue, or of several together. Distances in mm; NAN: not measured. */
typedef struct summary {
    double rms;              /* of the two directions, root mean square */
    double most_95, most;    /* 95th percentile and maximum: the larger one of the two directions */
    double rms_to, rms_from; /* of each direction: to the truth, from the truth */
    double kept;             /* of several tissues: the one that has changed most */
    double true_mm3, thickness_mm;
    double points;
} summary;

/* Order of two distances, for qsort. */
static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;

    return (x > y) - (x < y);
}

/* Sort distances and return their root mean square, and raise @p most_95 and @p most to their 95th
 * percentile and maximum. NAN if there are none. */
static double sum_up_one(distances *d, double *most_95, double *most)
{
    double sum = 0;

    if (!d->count)
        return NAN;
    qsort(d->mm, d->count, sizeof(double), compare);
    for (size_t i = 0; i < d->count; i++)
        sum += d->mm[i] * d->mm[i];
    *most_95 = fmax(*most_95, d->mm[(size_t)(0.95 * (double)d->count)]);
    *most = fmax(*most, d->mm[d->count - 1]);
    return sqrt(sum / (double)d->count);
}

/* Sum up the distances in both directions, which get sorted. */
static summary sum_up(distances *to, distances *from)
{
    summary s = {.most_95 = NAN, .most = NAN, .points = (double)(to->count + from->count)};

    s.rms_to = sum_up_one(to, &s.most_95, &s.most);
    s.rms_from = sum_up_one(from, &s.most_95, &s.most);
    s.rms = sqrt((s.rms_to * s.rms_to + s.rms_from * s.rms_from) / 2);
    return s;
}

/* Append the distances @p more to @p d. Aborts without memory. */
static void append(distances *d, const distances *more)
{
    if (!more->count)
        return;
    d->mm = realloc(d->mm, (d->count + more->count) * sizeof(double));
    if (!d->mm)
        abort();
    memcpy(d->mm + d->count, more->mm, more->count * sizeof(double));
    d->count += more->count;
}

/* Print a number as a member of a JSON object, null for NAN. */
static void print_member(const char *name, double value)
{
    if (isnan(value))
        printf(", \"%s\": null", name);
    else
        printf(", \"%s\": %.6g", name, value);
}

/* Print the members of a summary in a JSON object that has begun, and end it. */
static void print_members(const summary *s)
{
    print_member("true_mm3", s->true_mm3);
    print_member("thickness_mm", s->thickness_mm);
    print_member("volume_kept", s->kept);
    print_member("rms_mm", s->rms);
    print_member("p95_mm", s->most_95);
    print_member("max_mm", s->most);
    print_member("rms_to_truth_mm", s->rms_to);
    print_member("rms_from_truth_mm", s->rms_from);
    print_member("points", s->points);
    printf("}");
}

/* Print a row of the table after its title. */
static void print_cells(const summary *s)
{
    const double cells[] = {s->true_mm3 / 1000, s->thickness_mm, 100 * s->kept, s->rms,
                            s->most_95,         s->most,         s->rms_to,     s->rms_from};

    for (size_t i = 0; i < SC_COUNT_OF(cells); i++) {
        if (isnan(cells[i]))
            printf(" %9s", "-");
        else
            printf(" %9.*f", i < 3 ? 1 : 3, cells[i]);
    }
    printf("\n");
}

/* Print what comes before the tissues. */
static void print_begin(const comparison *c)
{
    if (!c->json) {
        printf("%-36s %9s %9s %9s %9s %9s %9s %9s %9s\n", "tissue", "true mL", "thick mm", "kept %",
               "rms mm", "95 %", "max", "to truth", "from it");
        return;
    }
    printf("{\"schema\": \"segcast-fidelity-against-1\"");
    print_member("smooth", c->meshes || c->how.surface == SC_SURFACE_VOXEL ? NAN : c->how.smooth);
    print_member("truth_smooth", c->truth_smooth);
    print_member("large_mm3", LARGE_MM3);
    print_member("large_thickness_mm", LARGE_MM);
    printf(", \"tissues\": [");
}

void print_comparison(const comparison *c, tissue *tissues, int count)
{
    distances to = {0}, from = {0};
    summary large;
    double kept = 1, mm3 = 0;
    int larges = 0;
    bool first = true;

    print_begin(c);
    for (int n = 0; n < count; n++) {
        tissue *t = &tissues[n];
        summary s;

        if (t->true_mm3 <= 0)
            continue;
        if (t->true_mm3 >= LARGE_MM3 && t->thickness_mm >= LARGE_MM && t->in_volume) {
            append(&to, &t->to);
            append(&from, &t->from);
            kept = fabs(t->kept - 1) > fabs(kept - 1) ? t->kept : kept;
            mm3 += t->true_mm3;
            larges++;
        }
        s = sum_up(&t->to, &t->from);
        s.kept = t->kept;
        s.true_mm3 = t->true_mm3;
        s.thickness_mm = t->thickness_mm;
        if (c->json) {
            printf("%s\n  {\"label\": %lld", first ? "" : ",", (long long)t->value);
            print_members(&s);
        } else {
            printf("%5lld %-30.30s", (long long)t->value, t->name);
            print_cells(&s);
        }
        first = false;
    }
    large = sum_up(&to, &from);
    large.kept = larges ? kept : NAN;
    large.true_mm3 = mm3;
    large.thickness_mm = NAN;
    if (c->json) {
        printf("],\n \"large\": {\"tissues\": %d", larges);
        print_members(&large);
        printf("}\n");
    } else {
        printf("%3d large: %.0f mL and %.0f mm thick     ", larges, LARGE_MM3 / 1000, LARGE_MM);
        print_cells(&large);
    }
    free(to.mm);
    free(from.mm);
}
