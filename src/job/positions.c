/* SPDX-License-Identifier: BSD-3-Clause */
/* The types of value of an animation: positions of planes, its length, and parts of it. */
#include "key.h"
#include "segcast/timeline.h"

#include <math.h>
#include <stdlib.h>

bool sc_parse_position(const sc_yaml *node, double *number, const char **unit)
{
    char *end;

    if (node->kind != SC_YAML_SCALAR)
        return false;
    *number = strtod(node->text, &end);
    if (end == node->text || !isfinite(*number) || fabs(*number) > 1e6 ||
        strspn(node->text, "0123456789.eE+-") < (size_t)(end - node->text)) /* such as 0x10 */
        return false;
    *unit = end + strspn(end, " ");
    return !**unit || !strcmp(*unit, "%") || !strcmp(*unit, "mm");
}

/* Read a plane position: "40%" is 40 percent; "12 mm" is 12 mm. A number without a unit is refused:
 * it would be millimetres to some users and percent to others. */
static sc_status read_plane_position(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                                     void *value)
{
    double number;
    const char *unit;

    if (!sc_parse_position(node, &number, &unit))
        return sc_wrong_type(ctx, node, key->type->expected);
    if (!*unit) {
        char expected[128];
        const bool is_share = number > 0 && number < 1;

        snprintf(expected, sizeof expected, "a unit behind the number: %.12g%% or %.12g mm",
                 is_share ? 100 * number : number, number);
        return sc_wrong_type(ctx, node, expected);
    }
    *(sc_plane_position *)value = (sc_plane_position){.value = number, .percent = *unit == '%'};
    return SC_OK;
}

/* Write what read_plane_position reads: "40%" or "12 mm". */
static sc_status write_plane_position(const sc_ctx *ctx, const sc_key *key, const void *value,
                                      sc_text *text)
{
    const sc_plane_position *position = value;

    return sc_write_number(ctx, position->value, 1, position->percent ? "%" : " mm", text);
}

/* Read a share from 0% to 100%, which is stored as a double from 0 to 1. */
static sc_status read_share(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    double number;
    const char *unit;

    if (!sc_parse_position(node, &number, &unit) || *unit != '%' || number < 0 || number > 100)
        return sc_wrong_type(ctx, node, key->type->expected);
    *(double *)value = number / 100;
    return SC_OK;
}

static sc_status write_share(const sc_ctx *ctx, const sc_key *key, const void *value, sc_text *text)
{
    return sc_write_number(ctx, *(const double *)value, 100, "%", text);
}

/* Write two doubles from 0 to 1 as "[20%, 80%]". */
static sc_status write_span(const sc_ctx *ctx, const sc_key *key, const void *value, sc_text *text)
{
    const double *span = value;

    SC_PASS(sc_text_add(ctx, text, "["));
    SC_PASS(sc_write_number(ctx, span[0], 100, "%, ", text));
    return sc_write_number(ctx, span[1], 100, "%]", text);
}

#define SECONDS_MOST 1e6 /* some eleven days */

/* @return whether all of @p text is digits, perhaps with decimals behind them. @param number it. */
static bool parse_decimal(const char *text, double *number)
{
    char *end;

    *number = strtod(text, &end);
    return end != text && !*end && strspn(text, "0123456789.") == strlen(text);
}

/* Read minutes and seconds, "0:10", or hours, too, "1:00:10": behind a colon there are two digits,
 * at most 59; the seconds may have decimals. @return false if @p text is anything else. */
static bool parse_clock(const char *text, double *seconds)
{
    double sum = 0, part;
    int parts = 0;
    bool is_last;

    do {
        const size_t digits = strspn(text, "0123456789");

        is_last = text[digits] != ':';
        part = strtod(text, NULL);
        if (digits == 0 || (is_last && !parse_decimal(text, &part)) ||
            (parts > 0 && (digits != 2 || part >= 60)) || ++parts > 3)
            return false;
        sum = 60 * sum + part;
        text += digits + 1;
    } while (!is_last);
    if (parts < 2)
        return false;
    *seconds = sum;
    return true;
}

sc_time_kind sc_time_of_text(const char *text, double *amount)
{
    static const struct {
        const char *unit;
        sc_time_kind kind;
        double factor;
    } units[] = {{"f", SC_TIME_FRAMES, 1},      {"frame", SC_TIME_FRAMES, 1},
                 {"frames", SC_TIME_FRAMES, 1}, {"s", SC_TIME_SECONDS, 1},
                 {"ms", SC_TIME_SECONDS, 1e-3}, {"min", SC_TIME_SECONDS, 60},
                 {"", SC_TIME_NUMBER, 1}};
    char *end;

    if (parse_clock(text, amount))
        return SC_TIME_SECONDS;
    *amount = strtod(text, &end);
    if (end == text || strspn(text, "0123456789.") != (size_t)(end - text)) /* such as 0x10 */
        return SC_TIME_NONE;
    end += strspn(end, " ");
    for (size_t i = 0; i < SC_COUNT_OF(units); i++) {
        if (!strcmp(end, units[i].unit)) {
            *amount *= units[i].factor;
            return units[i].kind;
        }
    }
    return SC_TIME_NONE;
}

bool sc_parse_seconds(const char *text, double *seconds)
{
    const sc_time_kind kind = sc_time_of_text(text, seconds);

    return kind == SC_TIME_SECONDS || kind == SC_TIME_NUMBER;
}

bool sc_parse_duration(const sc_yaml *node, double *seconds)
{
    return node->kind == SC_YAML_SCALAR && sc_parse_seconds(node->text, seconds) && *seconds > 0 &&
           *seconds <= SECONDS_MOST;
}

/* Read a time that is no share. @param frame where it lies, in frames from the beginning. @return
 * false if @p node is anything else. */
static bool parse_time(const sc_yaml *node, double *frame)
{
    const bool is_text = node->kind == SC_YAML_SCALAR && node->clock;
    const sc_time_kind kind = is_text ? sc_time_of_text(node->text, frame) : SC_TIME_NONE;

    if (kind != SC_TIME_FRAMES && kind != SC_TIME_SECONDS)
        return false;
    if (kind == SC_TIME_SECONDS)
        *frame *= node->clock->fps;
    if (fabs(*frame - floor(*frame + 0.5)) < 1e-9 * *frame) /* 1.1s at 30 fps are frame 33 */
        *frame = floor(*frame + 0.5);
    return true;
}

/* @return the share of the animation at which a frame lies. It is rounded down, so that what
 * happens at a frame happens there and not one later, and is the one that is written. */
static double share_of(const sc_clock *clock, double frame)
{
    const double share = clock->frames > 1 ? fmin(frame / (clock->frames - 1), 1) : 0;
    char digits[40];

    snprintf(digits, sizeof digits, "%.12g", floor(share * 100 * 1e9) / 1e9);
    return strtod(digits, NULL) / 100;
}

/* Say where the length of the animation is given, unless it is beside the time @p node: that of a
 * shot is in the shot, while the time may be the film's. @param out [bytes]; empty: beside it. */
static void name_length(const sc_yaml *length, const sc_yaml *node, char *out, size_t bytes)
{
    out[0] = '\0';
    if (!length || (length->line == node->line && !strcmp(length->origin, node->origin)))
        return;
    if (length->line > 0)
        snprintf(out, bytes, ", by %s:%d", length->origin, length->line);
    else
        snprintf(out, bytes, ", by %s", length->origin);
}

sc_status sc_read_time(const sc_ctx *ctx, const char *key, const sc_yaml *node, double *at,
                       bool *is_time)
{
    const sc_clock *clock = node->clock;
    const char *unit;
    char elsewhere[192];
    double frame;

    if (!parse_time(node, &frame)) {
        *is_time = sc_parse_position(node, at, &unit) && *unit == '%' && *at >= 0 && *at <= 100;
        *at /= 100;
        return SC_OK;
    }
    *is_time = true;
    *at = !clock->is_film ? share_of(clock, frame) : frame > 0 ? -frame / clock->fps : 0;
    if (clock->is_film || frame <= clock->frames * (1 + 1e-9))
        return SC_OK;
    name_length(clock->length, node, elsewhere, sizeof elsewhere);
    return sc_yaml_fail(ctx, node,
                        "%s: %s is behind the end of the animation, which has %.0f frame%s at %g "
                        "frames per second: %.6g s%s",
                        key, node->text, clock->frames, clock->frames > 1 ? "s" : "", clock->fps,
                        clock->frames / clock->fps, elsewhere);
}

/* Read begin and end of a part of the animation: two times, stored as two doubles in a row. */
static sc_status read_span(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    double span[2];
    bool are_times = node->kind == SC_YAML_LIST && node->count == 2;
    sc_status status = SC_OK;

    for (size_t i = 0; i < 2 && are_times; i++) {
        if (!sc_goes_on(&status,
                        sc_read_time(ctx, node->key, node->items[i], &span[i], &are_times)))
            return status;
    }
    if (!are_times || span[1] < span[0])
        return sc_wrong_type(ctx, node, key->type->expected);
    memcpy(value, span, sizeof span);
    return status;
}

/* A time above 0 is stored as a double, in seconds. */
static sc_status read_duration(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                               void *value)
{
    double seconds;

    if (!sc_parse_duration(node, &seconds))
        return sc_wrong_type(ctx, node, key->type->expected);
    *(double *)value = seconds;
    return SC_OK;
}

static sc_status write_duration(const sc_ctx *ctx, const sc_key *key, const void *value,
                                sc_text *text)
{
    return sc_write_number(ctx, *(const double *)value, 1, " s", text);
}

const sc_value_type sc_type_duration = {
    .name = "time",
    .expected = "a time such as 10s, 1.5 min, 500 ms or 0:10",
    .read = read_duration,
    .write = write_duration,
    .schema = "{anyOf: [{type: number}, {type: string, pattern: '^([0-9.]+ "
              "*(ms|s|min)?|([0-9]+:)?[0-9]+:[0-5][0-9](\\.[0-9]*)?)$'}]}",
};
const sc_value_type sc_type_plane_position = {
    .name = "position",
    .expected = "a position such as 40% or 12 mm",
    .read = read_plane_position,
    .write = write_plane_position,
    .schema = "{type: string, pattern: '^-?[0-9.]+([eE][-+]?[0-9]+)? *(%|mm)$'}",
};
const sc_value_type sc_type_share = {
    .name = "share",
    .expected = "a share from 0% to 100%, with its % sign",
    .read = read_share,
    .write = write_share,
    .schema = "{type: string, pattern: '^[0-9.]+ *%$'}",
};
const sc_value_type sc_type_span = {
    .name = "[begin, end]",
    .expected = "two rising times of the animation, such as [0%, 50%], [1.5s, 0:10] or [0f, 45f]",
    .read = read_span,
    .write = write_span,
    .schema = "{type: array, items: {type: string, pattern: '^([0-9.]+ "
              "*(%|f|frames?|s|ms|min)|([0-9]+:)?[0-9]+:[0-5][0-9](\\.[0-9]+)?)$'}, minItems: 2, "
              "maxItems: 2}",
};
