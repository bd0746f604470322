# SPDX-License-Identifier: Apache-2.0
fewray_unit_test(sampling fewray_guide)
fewray_unit_test(maps fewray_guide)
fewray_unit_test(odis_network fewray_guide)
fewray_unit_test(render fewray_guide)
foreach(name sampling maps odis_network render)
  target_compile_definitions(test_${name} PRIVATE FEWRAY_EMBREE=${embree_VERSION_MAJOR})
endforeach()
