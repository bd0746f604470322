# SPDX-License-Identifier: Apache-2.0
fewray_unit_test(metrics fewray_pipeline PkgConfig::jansson)
fewray_unit_test(options fewray_pipeline)
fewray_unit_test(layer_names fewray_pipeline)
fewray_unit_test(composite fewray_pipeline)
fewray_unit_test(command fewray_pipeline PkgConfig::jansson)
target_compile_definitions(test_command PRIVATE FEWRAY_COMMAND="$<TARGET_FILE:fewray>")
add_dependencies(test_command fewray)
add_subdirectory(metrics)
