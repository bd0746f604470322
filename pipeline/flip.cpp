/* SPDX-License-Identifier: Apache-2.0 */
/* LDR-FLIP. Sections and equations are those of Andersson et al. 2020. */

#include "pipeline/flip.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

namespace {

constexpr double pixels_per_degree = 67; /* the paper's display: 0.7 m away, 3840 pixels on 0.7 m */
constexpr float color_exponent = 0.7f, feature_exponent = 0.5f; /* q_c, q_f */
constexpr float knee_input = 0.4f, knee_output = 0.95f;         /* p_c, p_t */
constexpr float root_of_two = 1.41421356f;
constexpr double feature_width = 0.082; /* w, degrees */

/* Linear sRGB to XYZ (IEC 61966-2-1), over the white of D65. */
const cv::Matx33f to_xyz(10135552.0 / 24577794, 8788810.0 / 24577794, 4435075.0 / 24577794,
                         2613072.0 / 12288897, 8788810.0 / 12288897, 887015.0 / 12288897,
                         1425312.0 / 73733382, 8788810.0 / 73733382, 70074185.0 / 73733382);

cv::Matx33f rgb_to_white_xyz() {
    const cv::Vec3f white = to_xyz * cv::Vec3f(1, 1, 1);
    return cv::Matx33f::diag(cv::Vec3f(1 / white[0], 1 / white[1], 1 / white[2])) * to_xyz;
}

/* XYZ over white to the linear opponent space YyCxCz but for Yy's constant of -16, which no filter
 * and no difference sees (section 4.1). */
const cv::Matx33f xyz_to_opponent(0, 116, 0, 500, -500, 0, 0, 200, -200);

cv::Mat transform(const cv::Mat &image, const cv::Matx33f &matrix) {
    cv::Mat out;
    cv::transform(image, out, matrix);
    return out;
}

/* A row of weights that sum to one: a Gaussian exp(-pi^2 x^2 / b), x in degrees (eq. 3). */
cv::Mat contrast_kernel(double b, int radius) {
    cv::Mat row(1, 2 * radius + 1, CV_32F);
    for (int i = -radius; i <= radius; i++) {
        const double x = i / pixels_per_degree;
        row.at<float>(i + radius) = static_cast<float>(std::exp(-CV_PI * CV_PI * x * x / b));
    }
    return row / cv::sum(row)[0];
}

cv::Mat separable(const cv::Mat &plane, const cv::Mat &along_x, const cv::Mat &along_y) {
    cv::Mat out;
    cv::sepFilter2D(plane, out, CV_32F, along_x, along_y, cv::Point(-1, -1), 0,
                    cv::BORDER_REPLICATE);
    return out;
}

/* What the eye's contrast sensitivity leaves of each opponent channel (section 4.1, table 1). */
void filter_contrast(cv::Mat channels[3]) {
    constexpr double b_luma = 0.0047, b_red_green = 0.0053, b_blue_yellow[2] = {0.04, 0.025},
                     a_blue_yellow[2] = {34.1, 13.5};
    const int radius = static_cast<int>(
        std::ceil(3 * std::sqrt(b_blue_yellow[0] / (2 * CV_PI * CV_PI)) * pixels_per_degree));
    const cv::Mat luma = contrast_kernel(b_luma, radius),
                  red_green = contrast_kernel(b_red_green, radius);
    channels[0] = separable(channels[0], luma, luma);
    channels[1] = separable(channels[1], red_green, red_green);

    /* The sum of two Gaussians isn't separable; its two terms are, each weighted by its volume. */
    cv::Mat sum;
    double volume[2];
    for (int i = 0; i < 2; i++) {
        double length = 0;
        for (int k = -radius; k <= radius; k++)
            length += std::exp(-CV_PI * CV_PI * k * k /
                               (b_blue_yellow[i] * pixels_per_degree * pixels_per_degree));
        volume[i] = a_blue_yellow[i] * std::sqrt(CV_PI / b_blue_yellow[i]) * length * length;
    }
    for (int i = 0; i < 2; i++) {
        const cv::Mat kernel = contrast_kernel(b_blue_yellow[i], radius);
        const cv::Mat term = separable(channels[2], kernel, kernel);
        const double share = volume[i] / (volume[0] + volume[1]);
        sum = i == 0 ? cv::Mat(share * term) : cv::Mat(sum + share * term);
    }
    channels[2] = sum;
}

/* CIELAB's f. */
float lab_curve(float t) {
    constexpr float delta = 6.0f / 29;
    return t > delta * delta * delta ? std::cbrt(t) : t / (3 * delta * delta) + 4.0f / 29;
}

/* XYZ over white to CIELAB with Hunt's adjustment: chroma counts less in the dark (section 4.1). */
cv::Vec3f hunt_lab(const cv::Vec3f &xyz) {
    const float x = lab_curve(xyz[0]), y = lab_curve(xyz[1]), z = lab_curve(xyz[2]);
    const float lightness = 116 * y - 16;
    return {lightness, 0.01f * lightness * 500 * (x - y), 0.01f * lightness * 200 * (y - z)};
}

/* Distance HyAB (eq. 4): city block between lightness and chroma, Euclidean within chroma. */
float hyab(const cv::Vec3f &a, const cv::Vec3f &b) {
    const cv::Vec3f d = a - b;
    return std::abs(d[0]) + std::sqrt(d[1] * d[1] + d[2] * d[2]);
}

/* Spreads differences over 0..1 (eq. 5); most is the largest one. */
float redistribute(float difference, float most) {
    const float knee = knee_input * most;
    return difference < knee
               ? knee_output / knee * difference
               : knee_output + (difference - knee) / (most - knee) * (1 - knee_output);
}

cv::Vec3f clamp_unit(const cv::Vec3f &v) {
    return {std::clamp(v[0], 0.0f, 1.0f), std::clamp(v[1], 0.0f, 1.0f),
            std::clamp(v[2], 0.0f, 1.0f)};
}

/* Opponent channels, filtered, to what distances are taken in: (height, width, 3). */
cv::Mat perceived(const cv::Mat channels[3]) {
    cv::Mat image;
    cv::merge(channels, 3, image);
    const cv::Matx33f to_rgb = (xyz_to_opponent * rgb_to_white_xyz()).inv(),
                      to_white = rgb_to_white_xyz();
#pragma omp parallel for schedule(static)
    for (int y = 0; y < image.rows; y++)
        for (int x = 0; x < image.cols; x++) {
            cv::Vec3f &pixel = image.at<cv::Vec3f>(y, x);
            pixel = hunt_lab(to_white * clamp_unit(to_rgb * pixel));
        }
    return image;
}

/* First (order 1) or second (order 2) derivative of a Gaussian, whose positive weights sum to one
 * and whose negative ones sum to minus one (eq. 6; section 4.2). */
cv::Mat feature_kernel(int order, double deviation, int radius) {
    cv::Mat row(1, 2 * radius + 1, CV_32F);
    double above = 0, below = 0;
    for (int i = -radius; i <= radius; i++) {
        const double u = i / deviation,
                     value = (order == 1 ? -u : u * u - 1) * std::exp(-u * u / 2);
        (value > 0 ? above : below) += std::abs(value);
        row.at<float>(i + radius) = static_cast<float>(value);
    }
    for (int i = 0; i < row.cols; i++)
        row.at<float>(i) /= static_cast<float>(row.at<float>(i) > 0 ? above : below);
    return row;
}

/* How strong an edge (order 1) or a point (order 2) stands at each pixel of the luma in 0..1. */
cv::Mat feature_strength(const cv::Mat &luma, int order) {
    const double deviation = 0.5 * feature_width * pixels_per_degree;
    const int radius = static_cast<int>(std::ceil(3 * deviation));
    cv::Mat gauss(1, 2 * radius + 1, CV_32F), strength;
    for (int i = -radius; i <= radius; i++)
        gauss.at<float>(i + radius) =
            static_cast<float>(std::exp(-i * i / (2 * deviation * deviation)));
    gauss /= cv::sum(gauss)[0];
    const cv::Mat kernel = feature_kernel(order, deviation, radius);
    cv::magnitude(separable(luma, kernel, gauss), separable(luma, gauss, kernel), strength);
    return strength;
}

/* Largest color difference of all: between pure green and pure blue. */
float largest_difference() {
    const cv::Matx33f to_white = rgb_to_white_xyz();
    return std::pow(
        hyab(hunt_lab(to_white * cv::Vec3f(0, 1, 0)), hunt_lab(to_white * cv::Vec3f(0, 0, 1))),
        color_exponent);
}

struct Look {
    cv::Mat color, edges, points;
};

Look look_at(const cv::Mat &rgb) {
    cv::Mat channels[3];
    cv::split(transform(rgb, xyz_to_opponent * rgb_to_white_xyz()), channels);
    const cv::Mat luma = channels[0] / 116;
    Look look{{}, feature_strength(luma, 1), feature_strength(luma, 2)};
    filter_contrast(channels);
    look.color = perceived(channels);
    return look;
}

} // namespace

double flip_mean(const cv::Mat &test, const cv::Mat &reference) {
    const Look a = look_at(test), b = look_at(reference);
    const float most = largest_difference();
    cv::Mat row_sums(test.rows, 1, CV_64F);
#pragma omp parallel for schedule(static)
    for (int y = 0; y < test.rows; y++) {
        double sum = 0;
        for (int x = 0; x < test.cols; x++) {
            const float color = redistribute(
                std::pow(hyab(a.color.at<cv::Vec3f>(y, x), b.color.at<cv::Vec3f>(y, x)),
                         color_exponent),
                most);
            const float feature =
                std::max(std::abs(a.edges.at<float>(y, x) - b.edges.at<float>(y, x)),
                         std::abs(a.points.at<float>(y, x) - b.points.at<float>(y, x)));
            sum += std::pow(color, 1 - std::pow(feature / root_of_two, feature_exponent));
        }
        row_sums.at<double>(y) = sum;
    }
    return cv::sum(row_sums)[0] / (static_cast<double>(test.rows) * test.cols);
}
