// Makes a plugin of one that works: one with a symbol that nobody has.
extern "C" void raylex_not_defined_anywhere();

void (*raylex_unbound)() = raylex_not_defined_anywhere;
