// Turns a working plugin into one with an undefined symbol.
extern "C" void raylex_not_defined_anywhere();

void (*raylex_unbound)() = raylex_not_defined_anywhere;
