# SPDX-License-Identifier: Apache-2.0
fewray_unit_test(denoise_network fewray_denoise fewray_nn fewray_features)
fewray_unit_test(denoise_picture fewray_denoise fewray_features)
