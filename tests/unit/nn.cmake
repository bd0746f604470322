# SPDX-License-Identifier: Apache-2.0
fewray_unit_test(nn_kernels fewray_nn)
fewray_unit_test(nn_weights fewray_nn ZLIB::ZLIB)
