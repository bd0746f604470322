# SPDX-License-Identifier: Apache-2.0
# The renderer: radiance, sizes, geometry, materials, lights and cameras at their worst.
foreach(name radiance sizes film bsdfs cameras geometry lights half)
  fewray_stress_test(scene_${name} fewray_pipeline)
endforeach()
