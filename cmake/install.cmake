# The installed CMake package: find_package(omma), then link omma::omma. The library is static, so
# whoever links it needs Embree, TBB and the libraries of image formats too; ommaConfig.cmake finds
# them.
include(CMakePackageConfigHelpers)
set(omma_cmake_dir ${CMAKE_INSTALL_LIBDIR}/cmake/omma)
set(omma_find_embree "")
if(embree_FOUND)
  string(REGEX MATCH "^[0-9]+" embree_major "${embree_VERSION}")
  set(omma_find_embree "find_dependency(embree ${embree_major} CONFIG)")
endif()
set(omma_find_openexr "")
if(OMMA_OPENEXR)
  set(omma_find_openexr "find_dependency(OpenEXR CONFIG)
if(NOT TARGET OpenEXR::OpenEXR)
  add_library(OpenEXR::OpenEXR ALIAS OpenEXR::IlmImf)  # as OpenEXR 2 calls it
endif()")
endif()
set(omma_find_meshoptimizer "")
if(meshoptimizer_FOUND)
  set(omma_find_meshoptimizer "find_dependency(meshoptimizer CONFIG)")
endif()

install(TARGETS omma EXPORT ommaTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
        COMPONENT development)
install(DIRECTORY include/omma DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development
        FILES_MATCHING PATTERN "*.h")
install(EXPORT ommaTargets NAMESPACE omma:: DESTINATION ${omma_cmake_dir} COMPONENT development)
configure_package_config_file(cmake/ommaConfig.cmake.in ommaConfig.cmake
                              INSTALL_DESTINATION ${omma_cmake_dir})
# Before 1.0 a minor version may change what programs are written against.
write_basic_package_version_file(ommaConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/ommaConfig.cmake
              ${CMAKE_CURRENT_BINARY_DIR}/ommaConfigVersion.cmake
        DESTINATION ${omma_cmake_dir} COMPONENT development)
