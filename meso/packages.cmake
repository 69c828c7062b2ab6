# What meso needs besides; deal.II last, because it changes what the others find.
find_package(CGAL REQUIRED)
find_package(VTK 9 REQUIRED COMPONENTS ${TRAME_VTK_COMPONENTS})
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
