/// Simulates the fibers of a scene: run_workflow without the strains of yarns.

#include "workflows/workflow.h"

int main(int argc, char** argv) {
  return trame::workflows::run_program({.name = "simulate_fibers",
                                        .description = "Simulates the fibers of a scene.",
                                        .from_states = {},
                                        .from_results = {}},
                                       argc, argv);
}
