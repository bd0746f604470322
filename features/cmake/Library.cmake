# SPDX-License-Identifier: Apache-2.0
# libfewray, shared and static, of the objects of all folders, and how others find it: headers, pkg-config, CMake package.
include(CMakePackageConfigHelpers)
include(GNUInstallDirs)
set(cmake_dir ${CMAKE_CURRENT_LIST_DIR})
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/fewray)

set(parts fewray_features fewray_nn fewray_denoise)
set(header_folders features denoise)
set(dependencies OpenEXR::OpenEXRCore PkgConfig::libdeflate PNG::PNG ZLIB::ZLIB)
set(dependencies_private "-lOpenEXRCore -ldeflate -lpng -lz") # the same for pkg-config
if(FEWRAY_RENDERER)
  list(APPEND parts fewray_scene fewray_guide fewray_pipeline)
  list(APPEND header_folders guide pipeline)
  list(APPEND dependencies EXPAT::EXPAT PkgConfig::jansson)
  string(APPEND dependencies_private " -lexpat -ljansson")
endif()
string(APPEND dependencies_private " -fopenmp -ldl -lm")
# OpenMP by its flag, not its target: the path of the compiler's own library is another one elsewhere.
list(APPEND dependencies -fopenmp ${CMAKE_DL_LIBS} m)
list(TRANSFORM parts REPLACE "(.+)" "$<TARGET_OBJECTS:\\1>" OUTPUT_VARIABLE objects)

add_library(fewray_shared SHARED ${objects})
add_library(fewray_static STATIC ${objects})
foreach(library fewray_shared fewray_static)
  set_target_properties(${library} PROPERTIES OUTPUT_NAME fewray LINKER_LANGUAGE C
    LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR} ARCHIVE_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR})
  target_link_libraries(${library} PRIVATE ${dependencies})
  target_include_directories(${library} INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
endforeach()

set_target_properties(fewray_shared PROPERTIES EXPORT_NAME fewray
  VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR} LINK_DEPENDS ${cmake_dir}/fewray.map)
target_link_options(fewray_shared PRIVATE -Wl,--version-script=${cmake_dir}/fewray.map -Wl,-Bsymbolic-functions)

# An archive can't hide its internal names: they get a prefix, lest they meet the program's own.
set_target_properties(fewray_static PROPERTIES EXPORT_NAME static)
add_custom_command(TARGET fewray_static POST_BUILD VERBATIM
  COMMAND ${CMAKE_COMMAND} -DARCHIVE=$<TARGET_FILE:fewray_static> -DNM=${CMAKE_NM} -DOBJCOPY=${CMAKE_OBJCOPY}
  -P ${cmake_dir}/prefix_symbols.cmake)

install(TARGETS fewray_shared EXPORT fewray_shared)
install(TARGETS fewray_static EXPORT fewray_static)
foreach(kind shared static)
  install(EXPORT fewray_${kind} FILE fewray-${kind}.cmake NAMESPACE fewray:: DESTINATION ${package_dir})
endforeach()
foreach(folder ${header_folders})
  install(DIRECTORY ${CMAKE_SOURCE_DIR}/${folder}/include/fewray DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
    FILES_MATCHING PATTERN "*.h")
endforeach()

set(module_dir ${CMAKE_INSTALL_LIBDIR}/fewray)
configure_package_config_file(${cmake_dir}/fewrayConfig.cmake.in ${CMAKE_BINARY_DIR}/fewrayConfig.cmake
  INSTALL_DESTINATION ${package_dir} PATH_VARS module_dir NO_CHECK_REQUIRED_COMPONENTS_MACRO)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/fewrayConfigVersion.cmake COMPATIBILITY SameMajorVersion)
install(FILES ${CMAKE_BINARY_DIR}/fewrayConfig.cmake ${CMAKE_BINARY_DIR}/fewrayConfigVersion.cmake
  DESTINATION ${package_dir})

file(RELATIVE_PATH prefix_from_pc ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
string(REGEX REPLACE "/$" "" prefix_from_pc ${prefix_from_pc})
configure_file(${cmake_dir}/fewray.pc.in ${CMAKE_BINARY_DIR}/fewray.pc @ONLY)
install(FILES ${CMAKE_BINARY_DIR}/fewray.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
