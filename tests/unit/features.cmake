# SPDX-License-Identifier: Apache-2.0
fewray_unit_test(frame fewray_features)
fewray_unit_test(frame_repair fewray_features)
fewray_unit_test(image fewray_features)
fewray_unit_test(module fewray_features)
