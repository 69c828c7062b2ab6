/// What the compiler must refuse in the programs: a yarn that is meshed a second time.

auto second_mesh(const trame::micro::FiberMesh& fibers) { return trame::meso::mesh_yarn(fibers, 0, {}); }
