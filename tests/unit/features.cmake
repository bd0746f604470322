# SPDX-License-Identifier: Apache-2.0
fewray_unit_test(frame fewray_features)
fewray_unit_test(exr_header fewray_features)
fewray_unit_test(frame_repair fewray_features)
if(FEWRAY_RENDERER) # which has the module
  fewray_unit_test(image fewray_features)
  fewray_unit_test(module fewray_features)
endif()
fewray_unit_test(zip fewray_features ZLIB::ZLIB)
if(FEWRAY_RENDERER) # which finds OpenImageIO, the maker of the files
  fewray_unit_test(kept_files fewray_features PkgConfig::OpenImageIO)
  target_sources(test_kept_files PRIVATE ${CMAKE_CURRENT_SOURCE_DIR}/unit/foreign_file.cpp)
endif()
