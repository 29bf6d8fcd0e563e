/* Numbers with quantities. Angles are degrees in text and radians in structs. */
#include "core/label_text.h"
#include "core/property_impl.h"
#include "core/units.h"
#include <inttypes.h>
#include <math.h>
#include <string.h>

#define WHOLE_MOST 9007199254740992.0 /* 2^53 */
#define DEGREE (3.14159265358979323846 / 180)

double vvi_radians(double degrees)
{
    return degrees * DEGREE;
}

/* A degree step is up to 1.12 radian steps, so not every radian double has a degree double; where one has two, the
 * shorter text is what a person once wrote. */
double vvi_degrees(double radians)
{
    enum { NEIGHBOURS = 3 };
    const double guess = radians / DEGREE;
    char text[32];
    vvi_print_number(text, isfinite(guess) ? guess : 0);
    double best = guess, best_error = fabs(vvi_radians(guess) - radians);
    size_t best_length = strlen(text);
    double at = guess;
    for (int i = 0; i < NEIGHBOURS; i++)
        at = nextafter(at, -INFINITY);
    for (int i = 0; i <= 2 * NEIGHBOURS && isfinite(at); i++, at = nextafter(at, INFINITY)) {
        const double error = fabs(vvi_radians(at) - radians);
        vvi_print_number(text, at);
        if (error < best_error || (error == best_error && strlen(text) < best_length)) {
            best = at;
            best_error = error;
            best_length = strlen(text);
        }
    }
    return best;
}

const char *vvi_found(char out[64], const json_t *json)
{
    char number[32];
    switch (json_typeof(json)) {
    case JSON_OBJECT:
        return "an object";
    case JSON_ARRAY:
        snprintf(out, 64, "an array of %zu", json_array_size(json));
        return out;
    case JSON_STRING:
        snprintf(out, 64, "the text '%.40s'", json_string_value(json));
        return out;
    case JSON_INTEGER:
        snprintf(out, 64, "%" JSON_INTEGER_FORMAT, json_integer_value(json));
        return out;
    case JSON_REAL:
        vvi_print_number(number, json_real_value(json));
        snprintf(out, 64, "%s", number);
        return out;
    case JSON_TRUE:
        return "true";
    case JSON_FALSE:
        return "false";
    default:
        return "null";
    }
}

static const char *unit_words(const vv_property *property)
{
    return property->quantity == VV_Q_ANGLE ? " degrees" : "";
}

static vv_status check_range(double outside, const vv_property *property, const vvi_place *place)
{
    if (!isfinite(outside))
        return vvi_fail_place(place, VV_E_ARGUMENT, "expected a finite number");
    if (!property->limited || (outside >= property->min && outside <= property->max))
        return VV_OK;
    char value[32], min[32], max[32];
    vvi_print_number(value, outside);
    vvi_print_number(min, isfinite(property->min) ? property->min : -1.7976931348623157e308);
    vvi_print_number(max, isfinite(property->max) ? property->max : 1.7976931348623157e308);
    if (property->max >= 1e300)
        return vvi_fail_place(place, VV_E_ARGUMENT, "%s is out of range: expected at least %s%s", value, min,
                              unit_words(property));
    return vvi_fail_place(place, VV_E_ARGUMENT, "%s is out of range: expected %s to %s%s", value, min, max,
                          unit_words(property));
}

/* The number as it is written outside: degrees for angles. */
static vv_status read_outside(double *out, const vv_property *property, const json_t *json, const vvi_reading *reading,
                              const vvi_place *place)
{
    char found[64];
    if (json_is_number(json)) {
        *out = json_number_value(json);
        return VV_OK;
    }
    if (!json_is_string(json) || property->quantity == VV_Q_NONE)
        return vvi_fail_place(place, VV_E_ARGUMENT, "expected a number, found %s", vvi_found(found, json));
    char *where = vvi_place_text(place);
    if (!where)
        return vv_fail_memory(1);
    vv_status st = vvi_parse_quantity(out, json_string_value(json), property->quantity, reading->context, where);
    if (st != VV_OK) /* said again with the place as the error's own field */
        st = vvi_fail_place(place, st, "%s", vv_error_last()->message + strlen(where) + 2);
    else if (property->quantity == VV_Q_ANGLE)
        *out = vvi_degrees(*out);
    free(where);
    return st;
}

vv_status vvi_number_read(double *out, const vv_property *property, const json_t *json, const vvi_reading *reading,
                          const vvi_place *place)
{
    double outside = 0;
    vv_status st = read_outside(&outside, property, json, reading, place);
    if (st == VV_OK && (st = check_range(outside, property, place)) == VV_OK)
        *out = property->quantity == VV_Q_ANGLE ? vvi_radians(outside) : outside;
    return st;
}

vv_status vvi_integer_read(int64_t *out, const vv_property *property, const json_t *json, const vvi_reading *reading,
                           const vvi_place *place)
{
    int64_t whole = json_integer_value(json);
    double outside = (double)whole;
    if (!json_is_integer(json)) {
        const vv_status st = read_outside(&outside, property, json, reading, place);
        if (st != VV_OK)
            return st;
        if (!(fabs(outside) < WHOLE_MOST) || outside != floor(outside)) {
            char text[64];
            return vvi_fail_place(place, VV_E_ARGUMENT, "expected a whole number, found %s", vvi_found(text, json));
        }
        whole = (int64_t)outside;
    }
    const vv_status st = check_range(outside, property, place);
    if (st == VV_OK)
        *out = whole;
    return st;
}

vv_status vvi_label_id_read(vv_label_id *out, double *value_out, const vv_property *property, const json_t *json,
                            const vvi_place *place)
{
    char found[64];
    const char *text = json_string_value(json);
    const double real = json_real_value(json);
    double value = json_is_integer(json) ? (double)json_integer_value(json) : real;
    if (json_is_integer(json)) {
        *out = json_integer_value(json);
    } else if (text && vvi_label_parse(out, text, false)) {
        value = (double)*out;
    } else if (text && vvi_label_parse(out, text, true)) { /* 2^63 and more */
        value = vvi_label_value(*out, true);
    } else if (json_is_real(json) && fabs(real) < WHOLE_MOST && real == floor(real)) {
        *out = (vv_label_id)real;
    } else if (json_is_real(json) && real == floor(real)) {
        return vvi_fail_place(place, VV_E_ARGUMENT,
                              "%s may stand for several labels: numbers of 2^53 and more need all of their digits, as "
                              "in \"864691135000000001\"",
                              vvi_found(found, json));
    } else {
        return vvi_fail_place(place, VV_E_ARGUMENT, "expected a label, a whole number, found %s",
                              vvi_found(found, json));
    }
    if (value_out)
        *value_out = value;
    return check_range(value, property, place);
}

void vvi_label_id_print(vvi_text *text, vv_label_id id, double value)
{
    char digits[VVI_LABEL_DIGITS];
    const char *quote = fabs(value) < WHOLE_MOST ? "" : "\"";
    vvi_text_printf(text, "%s%s%s", quote, vvi_label_print(digits, id, id < 0 && value > 0), quote);
}

void vvi_number_print(vvi_text *text, double stored, vv_quantity quantity)
{
    char number[32];
    const double degrees = quantity == VV_Q_ANGLE ? vvi_degrees(stored) : 0;
    if (quantity == VV_Q_ANGLE && vvi_radians(degrees) != stored) {
        vvi_print_number(number, stored); /* no degree double gives these radians: only radians keep them */
        vvi_text_printf(text, "\"%srad\"", number);
        return;
    }
    vvi_print_number(number, quantity == VV_Q_ANGLE ? degrees : stored);
    vvi_text_add(text, number);
}
