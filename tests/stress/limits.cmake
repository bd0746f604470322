# SPDX-License-Identifier: Apache-2.0
fewray_stress_test(limits fewray_pipeline ZLIB::ZLIB)
add_dependencies(stress_limits fewray)
