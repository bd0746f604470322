# SPDX-License-Identifier: Apache-2.0
foreach(name scene_number scene_mesh_files scene_load scene_errors)
  fewray_unit_test(${name} fewray_scene)
endforeach()
