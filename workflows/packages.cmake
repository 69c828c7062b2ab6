# What the programs need besides.
find_package(nlohmann_json REQUIRED)
find_package(CLI11 REQUIRED)
find_package(X11 REQUIRED)
find_path(MUSTACHE_INCLUDE_DIR kainjow/mustache.hpp REQUIRED)
list(APPEND TRAME_VTK_COMPONENTS FiltersCore FiltersGeneral ImagingCore IOImage RenderingCore RenderingFreeType
                                 RenderingOpenGL2)
