# SPDX-License-Identifier: Apache-2.0
fewray_stress_test(wrong_guides fewray_guide ZLIB::ZLIB)
fewray_stress_test(guide_densities fewray_guide)
fewray_stress_test(dropped_samples fewray_guide)

# The bias study of any scene, and two small ones here.
fewray_stress_test(block_statistics m)
add_executable(stress_bias bias.c)
target_link_libraries(stress_bias PRIVATE fewray_pipeline m)
set(study stress_bias ${CMAKE_SOURCE_DIR}/examples/cornell-box.xml --width 32 --renders 16 --threads 1)
add_test(NAME stress_bias COMMAND ${study} --case path-tracing --case guided --case no-probes
  --case no-bsdf)
add_test(NAME stress_bias_later_passes COMMAND ${study} --case look-whole --case refined --case adaptive)

fewray_stress_test(same_bits fewray_pipeline)
fewray_stress_test(instruction_sets fewray_pipeline)
fewray_stress_test(stable_pictures fewray_pipeline)
