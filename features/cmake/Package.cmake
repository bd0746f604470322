# SPDX-License-Identifier: Apache-2.0
# The Debian package: cmake --preset package && cmake --build --preset package && cpack --config build-package/CPackConfig.cmake
install(FILES ${CMAKE_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} RENAME copyright)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME fewray)
set(CPACK_PACKAGE_CONTACT "fewray maintainers <maintainers@fewray.example>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "denoiser for path-traced pictures, and guided path tracer")
set(CPACK_PACKAGE_DESCRIPTION "fewray turns 1 to 8 paths a pixel into a finished picture, on a CPU. The command renders
Mitsuba 3 scenes, glTF and OBJ, guided by a small network, and denoises EXR files of any renderer.
This package has the library libfewray (shared, static, headers), too.")
# Paths in the files are those of the configured prefix.
set(CPACK_PACKAGING_INSTALL_PREFIX ${CMAKE_INSTALL_PREFIX})
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
# Not CPack's own, which warns of each module that it has no version in its name.
file(WRITE ${CMAKE_BINARY_DIR}/shlibs "libfewray ${PROJECT_VERSION_MAJOR} fewray (>= ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})\n")
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA ${CMAKE_BINARY_DIR}/shlibs)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(suggestions libopenexr-dev libdeflate-dev libpng-dev zlib1g-dev) # to link libfewray.a
if(FEWRAY_RENDERER)
  list(APPEND suggestions libexpat1-dev libjansson-dev)
endif()
list(JOIN suggestions ", " CPACK_DEBIAN_PACKAGE_SUGGESTS)
include(CPack)
