# SPDX-License-Identifier: Apache-2.0
add_library(fault_preload MODULE fault_preload.c)
set_target_properties(fault_preload PROPERTIES C_VISIBILITY_PRESET default)
target_compile_options(fault_preload PRIVATE -fno-sanitize=all)
target_link_options(fault_preload PRIVATE -fno-sanitize=all)
target_link_libraries(fault_preload PRIVATE ${CMAKE_DL_LIBS})

# Programs that run the command with a fault. With FEWRAY_TEST_ALL in the environment, fault_signals and fault_memory
# try every place instead of some.
foreach(name fault_disk fault_targets fault_inputs fault_signals fault_resources)
  fewray_stress_test(${name} fewray_features)
  target_compile_definitions(stress_${name} PRIVATE FAULT_LIBRARY="$<TARGET_FILE:fault_preload>")
  add_dependencies(stress_${name} fewray fault_preload)
endforeach()
add_test(NAME stress_fault_images COMMAND stress_fault_inputs test_image_*)

# The linker sends our own code's allocations to fault_wrap.c.
fewray_stress_test(fault_memory fewray_pipeline PkgConfig::jansson)
target_sources(stress_fault_memory PRIVATE fault_wrap.c)
foreach(call malloc calloc realloc aligned_alloc free mmap strdup)
  target_link_options(stress_fault_memory PRIVATE -Wl,--wrap=${call})
endforeach()
