# Installs the libraries into a folder, and builds and runs a program outside Trame that links them there.
#   cmake -DBUILD=… -DSOURCE=… -DFOLDER=… -P outside.cmake
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE failed OUTPUT_VARIABLE out ERROR_VARIABLE out)
  if(failed)
    message(FATAL_ERROR "${ARGN}:\n${out}")
  endif()
  set(out "${out}" PARENT_SCOPE)
endfunction()

file(REMOVE_RECURSE ${FOLDER})
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${FOLDER}/trame --component micro)
# Nothing of the other modules is asked for: where it cannot be found, micro is found and linked all the same.
run(${CMAKE_COMMAND} -S ${SOURCE} -B ${FOLDER}/micro -DCOMPONENT=micro -DCMAKE_PREFIX_PATH=${FOLDER}/trame
    -DCMAKE_BUILD_TYPE=Release -DCMAKE_DISABLE_FIND_PACKAGE_VTK=ON -DCMAKE_DISABLE_FIND_PACKAGE_CGAL=ON
    -DCMAKE_DISABLE_FIND_PACKAGE_deal.II=ON)
run(${CMAKE_COMMAND} --build ${FOLDER}/micro)
run(${CMAKE_COMMAND} -E chdir ${FOLDER} ${FOLDER}/micro/outside)
# E A (λ² − 1) λ / 2 of a fiber stretched by λ = 1.01, E A = 3 GPa · π (10 µm)².
if(NOT out MATCHES "^9\\.5[0-9]* mN")
  message(FATAL_ERROR "the force is ${out}, not 9.567 mN")
endif()

run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${FOLDER}/trame --component meso)
run(${CMAKE_COMMAND} -S ${SOURCE} -B ${FOLDER}/meso -DCOMPONENT=meso -DCMAKE_PREFIX_PATH=${FOLDER}/trame
    -DCMAKE_BUILD_TYPE=Release)
run(${CMAKE_COMMAND} --build ${FOLDER}/meso)
run(${FOLDER}/meso/outside ${FOLDER}/states.h5)
if(NOT out MATCHES "fiber: 0 tetrahedra")
  message(FATAL_ERROR "a single fiber has no mesh, but: ${out}")
endif()
