# The libraries for other programs, a component for each module, and the programs:
#   cmake --install build/release --prefix DIR [--component micro|meso|programs|python]
#   find_package(Trame REQUIRED COMPONENTS micro meso)   target_link_libraries(mine Trame::micro Trame::meso)
include(CMakePackageConfigHelpers)
set(trame_cmake_dir ${CMAKE_INSTALL_LIBDIR}/cmake/Trame)

function(trame_export component)
  set_target_properties(trame_${component} PROPERTIES EXPORT_NAME ${component})
  install(TARGETS ${ARGN} EXPORT Trame_${component} ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT ${component})
  install(EXPORT Trame_${component} NAMESPACE Trame:: DESTINATION ${trame_cmake_dir} COMPONENT ${component}
          FILE Trame_${component}.cmake)
  install(DIRECTORY ${component} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/trame COMPONENT ${component}
          FILES_MATCHING PATTERN *.h)
endfunction()

trame_export(micro trame_micro trame_options trame_core trame_cholmod trame_scene trame_snapshot trame_solve
             trame_effects trame_simulate)
configure_package_config_file(TrameConfig.cmake.in ${CMAKE_BINARY_DIR}/TrameConfig.cmake
                              INSTALL_DESTINATION ${trame_cmake_dir})
write_basic_package_version_file(${CMAKE_BINARY_DIR}/TrameConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/TrameConfig.cmake ${CMAKE_BINARY_DIR}/TrameConfigVersion.cmake
        DESTINATION ${trame_cmake_dir} COMPONENT micro)
if(TRAME_MESO)
  trame_export(meso trame_meso trame_yarn_frame trame_dealii)
endif()
# Python: plain files, where Debian's Python looks below /usr and /usr/local.
install(DIRECTORY data/python/trame DESTINATION lib/python3/dist-packages COMPONENT python FILES_MATCHING PATTERN *.py)
if(TRAME_WORKFLOWS)
  install(TARGETS run_workflow simulate_fibers strain_post render_patch accuracy_cost
          RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT programs)
endif()
