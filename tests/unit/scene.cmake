# SPDX-License-Identifier: Apache-2.0
foreach(name scene_number scene_mesh_files scene_obj_chunks scene_load scene_errors scene_bsdfs
        scene_emitters camera_path gltf obj_mtl)
  fewray_unit_test(${name} fewray_scene)
endforeach()
fewray_unit_test(scene_serialized fewray_scene ZLIB::ZLIB)
