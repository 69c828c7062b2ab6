# Configures micro alone where none of the packages of the other modules is to be had.
#   cmake -DSOURCE=… -DFOLDER=… -P micro_alone.cmake
file(REMOVE_RECURSE ${FOLDER})
set(absent "")
foreach(package VTK CGAL deal.II X11 CLI11 nlohmann_json GTest benchmark)
  list(APPEND absent -DCMAKE_DISABLE_FIND_PACKAGE_${package}=ON)
endforeach()
execute_process(COMMAND ${CMAKE_COMMAND} -S ${SOURCE} -B ${FOLDER} -DTRAME_MESO=OFF ${absent}
                RESULT_VARIABLE failed OUTPUT_VARIABLE out ERROR_VARIABLE out)
if(failed)
  message(FATAL_ERROR "${out}")
endif()
