// What the checks of plugins share: they run the installed program and look at its files.
#pragma once

#include <string>
#include <vector>

extern int failures;

void check(bool holds, const std::string& what);
void write(const std::string& file, const std::string& text);
std::string read(const std::string& file);
/// The option that loads a plugin of this project.
std::string plugin(const std::string& name);
/// Exit code; the program's error stream is left in err.txt.
int run(const std::string& arguments);
/// The R plane of a layer of the last render; empty when there is none.
std::vector<float> read_layer(const std::string& layer);
/// The R plane of a layer (the beauty's without a name); empty when the render failed.
std::vector<float> render(const std::string& arguments, const std::string& layer = "");
/// A wall that fills the image, x and y from -1 to 1, seen from straight above; `world` follows WorldBegin.
void write_scene(const std::string& integrator, const std::string& world);
extern const std::string wall;
std::size_t pixel(int x, int y);

void check_promises();
