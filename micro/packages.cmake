# Packages, in the order that works on Debian 12; deal.II last, because it changes what the others find.
set(HDF5_PREFER_PARALLEL FALSE)
find_package(HDF5 REQUIRED COMPONENTS C)
find_package(Threads REQUIRED)
find_package(OpenMP REQUIRED COMPONENTS CXX)
find_package(Eigen3 REQUIRED NO_MODULE)
find_package(fmt REQUIRED)
find_package(spdlog REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(tomlplusplus REQUIRED)
find_package(CLI11 REQUIRED)

# SuiteSparse has no CMake configuration in Debian 12.
find_path(CHOLMOD_INCLUDE_DIR cholmod.h PATH_SUFFIXES suitesparse REQUIRED)
find_library(CHOLMOD_LIBRARY cholmod REQUIRED)
find_library(OPENBLAS_LIBRARY openblas REQUIRED)
add_library(trame_cholmod INTERFACE)
target_include_directories(trame_cholmod SYSTEM INTERFACE ${CHOLMOD_INCLUDE_DIR})
target_link_libraries(trame_cholmod INTERFACE ${CHOLMOD_LIBRARY} ${OPENBLAS_LIBRARY})

find_path(UDUNITS2_INCLUDE_DIR udunits2.h REQUIRED)
find_library(UDUNITS2_LIBRARY udunits2 REQUIRED)

find_package(CGAL REQUIRED)
find_package(X11 REQUIRED)
find_package(VTK 9 REQUIRED COMPONENTS CommonCore CommonDataModel FiltersCore FiltersGeneral ImagingCore IOImage IOXML
                                       RenderingCore RenderingFreeType RenderingOpenGL2)
find_package(deal.II 9.4 REQUIRED)

# deal.II's own target forces flags, the gold linker and the headers of a parallel HDF5; this one brings only what is used.
add_library(trame_dealii INTERFACE)
set(dealii_includes ${DEAL_II_INCLUDE_DIRS})
list(FILTER dealii_includes EXCLUDE REGEX "hdf5|^/usr/include$")
target_include_directories(trame_dealii SYSTEM INTERFACE ${dealii_includes})
target_compile_definitions(trame_dealii INTERFACE BOOST_NO_AUTO_PTR OMPI_SKIP_MPICXX=1)
find_library(TRAME_DEALII_LIBRARY deal.ii REQUIRED)
find_library(TRAME_TBB_LIBRARY tbb REQUIRED)
find_library(TRAME_TEUCHOSCOMM_LIBRARY trilinos_teuchoscomm REQUIRED)
find_library(TRAME_TEUCHOSCORE_LIBRARY trilinos_teuchoscore REQUIRED)
find_library(TRAME_MPI_LIBRARY mpi HINTS /usr/lib/${CMAKE_LIBRARY_ARCHITECTURE}/openmpi/lib REQUIRED)
target_link_libraries(trame_dealii INTERFACE ${TRAME_DEALII_LIBRARY} ${TRAME_TBB_LIBRARY}
                      ${TRAME_TEUCHOSCOMM_LIBRARY} ${TRAME_TEUCHOSCORE_LIBRARY} ${TRAME_MPI_LIBRARY})
