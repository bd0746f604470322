/* SPDX-License-Identifier: Apache-2.0 */
/* The shim over OpenCV (core and imgproc), the module "opencv". Exceptions end here. */

#include "pipeline/opencv.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <numeric>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "pipeline/flip.h"

namespace {

/* --- metrics: every Mat is one channel of doubles, one channel of the picture after the other to
 * spare memory */

constexpr double relative_floor = 0.01; /* added to r^2 and |r|, so that black pixels don't rule */
constexpr int ssim_window = 11, ssim_border = 5;

/* What is known of the pixels before their values are looked at. Masks hold 255 or 0. */
struct Masks {
    cv::Mat good;     /* the reference is finite */
    cv::Mat bad_test; /* the test isn't, there */
};

bool finite_pixel(float *const planes[3], size_t i) {
    return std::isfinite(planes[0][i]) && std::isfinite(planes[1][i]) &&
           std::isfinite(planes[2][i]);
}

Masks find_masks(float *const test[3], float *const reference[3], int width, int height) {
    Masks masks{cv::Mat(height, width, CV_8U), cv::Mat(height, width, CV_8U)};
    const size_t count = static_cast<size_t>(width) * height;
    for (size_t i = 0; i < count; i++) {
        const bool good = finite_pixel(reference, i);
        masks.good.data[i] = good ? 255 : 0;
        masks.bad_test.data[i] = good && !finite_pixel(test, i) ? 255 : 0;
    }
    return masks;
}

cv::Mat plane_of(const float *data, int width, int height) {
    cv::Mat plane;
    cv::Mat(height, width, CV_32F, const_cast<float *>(data)).convertTo(plane, CV_64F);
    return plane;
}

/* sRGB transfer function of values cut to [0, 1] (IEC 61966-2-1). */
cv::Mat display_of(const cv::Mat &linear) {
    const cv::Mat cut = cv::min(cv::max(linear, 0.0), 1.0);
    cv::Mat curve;
    cv::pow(cut, 1 / 2.4, curve);
    curve = 1.055 * curve - 0.055;
    cv::Mat(12.92 * cut).copyTo(curve, cut <= 0.0031308);
    return curve;
}

cv::Mat blur(const cv::Mat &plane) {
    cv::Mat out;
    cv::GaussianBlur(plane, out, cv::Size(ssim_window, ssim_window), 1.5, 1.5, cv::BORDER_REFLECT);
    return out;
}

/* Mean SSIM of one channel in [0, 1] (Wang et al. 2004, eq. 13). */
double mean_ssim(const cv::Mat &x, const cv::Mat &y) {
    const double c1 = 0.01 * 0.01, c2 = 0.03 * 0.03;
    const cv::Mat mean_x = blur(x), mean_y = blur(y);
    const cv::Mat mean_xx = mean_x.mul(mean_x), mean_yy = mean_y.mul(mean_y),
                  mean_xy = mean_x.mul(mean_y);
    const cv::Mat var_sum = blur(x.mul(x)) - mean_xx + blur(y.mul(y)) - mean_yy;
    const cv::Mat covariance = blur(x.mul(y)) - mean_xy;
    const cv::Mat above = cv::Mat(2 * mean_xy + c1).mul(2 * covariance + c2);
    const cv::Mat below = cv::Mat(mean_xx + mean_yy + c1).mul(var_sum + c2);
    const cv::Mat ssim = above / below;
    const cv::Rect inner(ssim_border, ssim_border, x.cols - 2 * ssim_border,
                         x.rows - 2 * ssim_border);
    return cv::mean(ssim(inner))[0];
}

/* Mean of the values without the 0.01 % that are highest. They get reordered. */
double trimmed_mean(std::vector<double> &values) {
    const size_t kept =
        values.size() - static_cast<size_t>(std::ceil(1e-4 * static_cast<double>(values.size())));
    if (kept == 0)
        return std::numeric_limits<double>::quiet_NaN();
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(kept) - 1,
                     values.end());
    return cv::mean(cv::Mat(static_cast<int>(kept), 1, CV_64F, values.data()))[0];
}

/* Share of the sum that the highest 1 % of the values hold; 0 of zeros. They get reordered. */
double top_share(std::vector<double> &values) {
    const size_t top = static_cast<size_t>(std::ceil(1e-2 * static_cast<double>(values.size())));
    const auto first = values.end() - static_cast<std::ptrdiff_t>(top);
    if (top == 0)
        return 0;
    std::nth_element(values.begin(), first, values.end());
    const double rest = std::accumulate(values.begin(), first, 0.0),
                 worst = std::accumulate(first, values.end(), 0.0);
    return worst > 0 ? worst / (rest + worst) : 0;
}

std::vector<double> good_values(const cv::Mat &error, const cv::Mat &good) {
    std::vector<double> values;
    values.reserve(error.total());
    for (size_t i = 0; i < error.total(); i++)
        if (good.data[i])
            values.push_back(error.ptr<double>()[i]);
    return values;
}

/* Adds one channel's share to the sums; error_map gathers the mrse of each pixel, shown what a
 * display emits of x and of r. */
void add_channel(cv::Mat x, cv::Mat r, const float *noise, const Masks &masks, fewray_metrics &sums,
                 double &display_mse, cv::Mat &error_map, cv::Mat shown[2]) {
    const cv::Mat bad_reference = ~masks.good;
    r.setTo(0, bad_reference);
    x.setTo(0, bad_reference);
    cv::Mat(2 * r + 1).copyTo(x, masks.bad_test);

    const cv::Mat difference = x - r, squared = difference.mul(difference),
                  magnitude = cv::abs(difference);
    const cv::Mat weight = r.mul(r) + relative_floor;
    error_map += squared / weight / 3;
    sums.mse += cv::mean(squared, masks.good)[0] / 3;
    sums.l1 += cv::mean(magnitude, masks.good)[0] / 3;
    sums.mape += cv::mean(magnitude / (cv::abs(r) + relative_floor), masks.good)[0] / 3;
    if (noise) {
        const cv::Mat deviation = plane_of(noise, x.cols, x.rows);
        sums.ref_mrse += cv::mean(deviation.mul(deviation) / weight, masks.good)[0] / 3;
    }
    const cv::Mat *const linear[2] = {&x, &r};
    for (int i = 0; i < 2; i++)
        cv::Mat(cv::min(cv::max(*linear[i], 0.0), 1.0)).convertTo(shown[i], CV_32F);
    const cv::Mat shown_x = display_of(x), shown_r = display_of(r),
                  shown_difference = shown_x - shown_r;
    display_mse += cv::mean(shown_difference.mul(shown_difference), masks.good)[0] / 3;
    if (x.cols >= ssim_window && x.rows >= ssim_window)
        sums.ssim_loss -= mean_ssim(shown_x, shown_r) / 3;
    else
        sums.ssim_loss = std::numeric_limits<double>::quiet_NaN();
}

double flip_of(const cv::Mat shown[3][2]) {
    cv::Mat pictures[2];
    for (int i = 0; i < 2; i++)
        cv::merge(std::vector<cv::Mat>{shown[0][i], shown[1][i], shown[2][i]}, pictures[i]);
    return flip_mean(pictures[0], pictures[1]);
}

void measure(float *const test[3], float *const reference[3], float *const noise[3], int width,
             int height, fewray_metrics &metrics) {
    const Masks masks = find_masks(test, reference, width, height);
    const int good = cv::countNonZero(masks.good);
    metrics = {};
    metrics.ssim_loss = 1;
    double display_mse = 0;
    cv::Mat error_map = cv::Mat::zeros(height, width, CV_64F);
    cv::Mat shown[3][2];
    for (int c = 0; c < 3; c++)
        add_channel(plane_of(test[c], width, height), plane_of(reference[c], width, height),
                    noise ? noise[c] : nullptr, masks, metrics, display_mse, error_map, shown[c]);
    metrics.flip = flip_of(shown);
    metrics.mrse = cv::mean(error_map, masks.good)[0];
    std::vector<double> errors = good_values(error_map, masks.good);
    metrics.mrse_trimmed = trimmed_mean(errors);
    metrics.mrse_top1 = top_share(errors);
    metrics.psnr =
        display_mse > 0 ? -10 * std::log10(display_mse) : std::numeric_limits<double>::infinity();
    metrics.n_nonfinite = cv::countNonZero(masks.bad_test);
    metrics.n_ref_nonfinite = static_cast<long long>(masks.good.total()) - good;
    metrics.mrse_net = metrics.mrse - metrics.ref_mrse;
    if (!noise || !std::isfinite(metrics.ref_mrse))
        metrics.ref_mrse = metrics.mrse_net = std::numeric_limits<double>::quiet_NaN();
}

cv::Scalar scalar_of(canvas_color color) {
    return cv::Scalar(color >> 16 & 255, color >> 8 & 255, color & 255);
}

cv::Rect rect_of(box place) {
    return cv::Rect(place.x, place.y, place.width, place.height);
}

/* OpenCV's Hershey letters have capitals of 21 pixels at scale 1. */
constexpr int font = cv::FONT_HERSHEY_SIMPLEX;
double font_scale(double size) {
    return size / 21;
}
int font_thickness(double size) {
    return std::max(1, static_cast<int>(std::lround(size / 9)));
}

int measure_checked(float *const test[3], float *const reference[3], float *const noise[3],
                    int width, int height, fewray_metrics *metrics, fewray_error *error) {
    try {
        measure(test, reference, noise, width, height, *metrics);
    } catch (const std::exception &) {
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, nullptr, 0,
                           "no memory for the metrics of %dx%d pixels", width, height);
    }
    if (metrics->n_ref_nonfinite == static_cast<long long>(width) * height)
        return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, nullptr, 0,
                           "the reference has no finite pixel to compare with");
    return FEWRAY_OK;
}

} // namespace

struct canvas {
    cv::Mat pixels;
    bool failed;
};

namespace {

/* Runs a drawing; what it throws makes the canvas void. */
template <class Drawing> void draw(canvas *target, Drawing drawing) {
    try {
        drawing(target->pixels);
    } catch (const std::exception &) {
        target->failed = true;
    }
}

canvas *create(int width, int height, canvas_color background) {
    try {
        return new canvas{cv::Mat(height, width, CV_8UC3, scalar_of(background)), false};
    } catch (const std::exception &) {
        return nullptr;
    }
}

void destroy(canvas **target) {
    delete *target;
    *target = nullptr;
}

const uint8_t *pixels(const canvas *target) {
    return target->failed ? nullptr : target->pixels.data;
}

void paste(canvas *target, const uint8_t *rgb, int width, int height, box part, box place) {
    draw(target, [&](cv::Mat &pixels) {
        const cv::Mat source(height, width, CV_8UC3, const_cast<uint8_t *>(rgb));
        cv::Mat into = pixels(rect_of(place));
        cv::resize(source(rect_of(part)), into, into.size(), 0, 0,
                   place.width < part.width ? cv::INTER_AREA : cv::INTER_NEAREST);
    });
}

void fill(canvas *target, box place, canvas_color color) {
    draw(target, [&](cv::Mat &pixels) {
        cv::rectangle(pixels, rect_of(place), scalar_of(color), cv::FILLED);
    });
}

void outline(canvas *target, box place, int thickness, canvas_color color) {
    draw(target, [&](cv::Mat &pixels) {
        cv::rectangle(pixels, rect_of(place), scalar_of(color), thickness);
    });
}

/* OpenCV's coordinates for drawing, in fractions of a pixel. */
constexpr int fraction_bits = 6;
int fixed_of(double pixels) {
    return static_cast<int>(std::lround(pixels * (1 << fraction_bits)));
}

std::vector<cv::Point> points_of(const double *points, int count) {
    std::vector<cv::Point> out;
    for (int i = 0; i < count; i++)
        out.emplace_back(fixed_of(points[2 * i]), fixed_of(points[2 * i + 1]));
    return out;
}

void polyline(canvas *target, const double *points, int count, int thickness, canvas_color color) {
    draw(target, [&](cv::Mat &pixels) {
        cv::polylines(pixels, points_of(points, count), false, scalar_of(color), thickness,
                      cv::LINE_AA, fraction_bits);
    });
}

void polygon(canvas *target, const double *points, int count, canvas_color color) {
    draw(target, [&](cv::Mat &pixels) {
        cv::fillPoly(pixels, std::vector<std::vector<cv::Point>>{points_of(points, count)},
                     scalar_of(color), cv::LINE_AA, fraction_bits);
    });
}

void disc(canvas *target, double x, double y, double radius, canvas_color color) {
    draw(target, [&](cv::Mat &pixels) {
        cv::circle(pixels, cv::Point(fixed_of(x), fixed_of(y)), fixed_of(radius), scalar_of(color),
                   cv::FILLED, cv::LINE_AA, fraction_bits);
    });
}

void text(canvas *target, int x, int y, double size, canvas_color color, const char *text) {
    draw(target, [&](cv::Mat &pixels) {
        cv::putText(pixels, text, cv::Point(x, y), font, font_scale(size), scalar_of(color),
                    font_thickness(size), cv::LINE_AA);
    });
}

int text_width(double size, const char *text) {
    try {
        int baseline;
        return cv::getTextSize(text, font, font_scale(size), font_thickness(size), &baseline).width;
    } catch (const std::exception &) {
        return 0;
    }
}

bool heat_colors(const uint8_t *values, int count, uint8_t *rgb) {
    try {
        cv::Mat bgr, out(count, 1, CV_8UC3, rgb);
        cv::applyColorMap(cv::Mat(count, 1, CV_8U, const_cast<uint8_t *>(values)), bgr,
                          cv::COLORMAP_INFERNO);
        cv::cvtColor(bgr, out, cv::COLOR_BGR2RGB);
        return true;
    } catch (const std::exception &) {
        return false;
    }
}

} // namespace

const struct opencv fewray_opencv = {
    measure_checked, create,  destroy, pixels, paste,      fill,        outline,
    polyline,        polygon, disc,    text,   text_width, heat_colors,
};
