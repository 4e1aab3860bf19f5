#include "experiments/cli/command_line.h"
#include "experiments/program/interrupt.h"

int main(int argc, char** argv) {
    raylex::experiments::install_interrupt_handler();
    return raylex::experiments::run_command_line(argc, argv);
}
