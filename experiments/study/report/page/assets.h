// Scripts and styles of a study's page, and the drawing of its plots.
#pragma once

#include <string>
#include <string_view>

#include "lpe/result.h"

namespace raylex::experiments {

std::string_view plot_script();      ///< plot.js
std::string_view bench_script();     ///< bench.js
std::string_view study_script();     ///< study_page.js
std::string_view study_style();      ///< study.css
std::string_view d3_default_path();  ///< path of d3 that CMake found; empty if none

/// Returns the text of the installed d3 (version 3, Debian's libjs-d3): from $RAYLEX_D3, else from the path that CMake
/// found, else from Debian's path. Errors name the package.
Result<std::string> read_d3();

/// Draws plots like the page, with the same script and d3, in an embedded interpreter (Duktape), so that figures need
/// neither a browser nor Node.js.
class PlotDrawer {
  public:
    static Result<PlotDrawer> create(const std::string& d3);
    PlotDrawer(PlotDrawer&& other) noexcept;
    PlotDrawer& operator=(PlotDrawer&& other) noexcept;
    ~PlotDrawer();

    /// Returns the SVG text of a plot's JSON.
    Result<std::string> draw(const std::string& json);

  private:
    PlotDrawer() = default;
    void* context_ = nullptr;
};

}  // namespace raylex::experiments
