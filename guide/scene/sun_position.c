/* SPDX-License-Identifier: Apache-2.0 */
/* The PSA algorithm: good to a hundredth of a degree for today's years. */

#include "guide/scene/sun_position.h"

static const double radians = 3.14159265358979323846 / 180;

/* Days since noon of 1 January 2000, universal time. */
static double days_since_2000(const struct sun_time *t, double hours) {
    long long month = t->month, year = t->year, carry = (month - 14) / 12;
    long long day = (1461 * (year + 4800 + carry)) / 4 + (367 * (month - 2 - 12 * carry)) / 12 -
                    (3 * ((year + 4900 + carry) / 100)) / 4 + t->day - 32075;
    return (double)day - 0.5 + hours / 24 - 2451545.0;
}

struct vec3 sun_position(const struct sun_time *t) {
    double hours = t->hour - t->timezone + (t->minute + t->second / 60) / 60;
    double days = days_since_2000(t, hours);
    double omega = 2.1429 - 0.0010394594 * days;
    double longitude = 4.8950630 + 0.017202791698 * days, anomaly = 6.2400600 + 0.0172019699 * days;
    double ecliptic = longitude + 0.03341607 * sin(anomaly) + 0.00034894 * sin(2 * anomaly) -
                      0.0001134 - 0.0000203 * sin(omega);
    double obliquity = 0.4090928 - 6.2140e-9 * days + 0.0000396 * cos(omega);
    double ascension = atan2(cos(obliquity) * sin(ecliptic), cos(ecliptic));
    double declination = asin(sin(obliquity) * sin(ecliptic));
    double sidereal = 6.6974243242 + 0.0657098283 * days + hours;
    double hour_angle = (sidereal * 15 + t->longitude) * radians - ascension;
    double latitude = t->latitude * radians;
    double cos_zenith =
        cos(latitude) * cos(hour_angle) * cos(declination) + sin(declination) * sin(latitude);
    double zenith = acos(fmax(-1, fmin(1, cos_zenith)));
    double azimuth =
        atan2(-sin(hour_angle), tan(declination) * cos(latitude) - sin(latitude) * cos(hour_angle));
    zenith += 6371.01 / 149597890 * sin(zenith); /* parallax: we stand on the earth's surface */
    double south = azimuth - 180 * radians;
    return vec((float)(cos(south) * sin(zenith)), (float)(sin(south) * sin(zenith)),
               (float)cos(zenith));
}
