// What a study's page is made of, and the drawing of its plots.
#pragma once

#include <string>
#include <string_view>

#include "lpe/result.h"

namespace raylex::experiments {

std::string_view plot_script();      ///< plot.js
std::string_view bench_script();     ///< bench.js
std::string_view study_script();     ///< study_page.js
std::string_view study_style();      ///< study.css
std::string_view d3_default_path();  ///< where CMake found d3; empty when it did not

/// The text of the installed d3 (version 3, Debian's libjs-d3): $RAYLEX_D3 when it is set, else where CMake found it,
/// else Debian's place. Errors name the package.
Result<std::string> read_d3();

/// Draws plots as the page does: the same script and d3 in an embedded interpreter (Duktape). A browser or Node.js
/// would do it too, but neither can be asked of everybody who wants a figure.
class PlotDrawer {
  public:
    static Result<PlotDrawer> create(const std::string& d3);
    PlotDrawer(PlotDrawer&& other) noexcept;
    PlotDrawer& operator=(PlotDrawer&& other) noexcept;
    ~PlotDrawer();

    /// SVG text of a plot's JSON.
    Result<std::string> draw(const std::string& json);

  private:
    PlotDrawer() = default;
    void* context_ = nullptr;
};

}  // namespace raylex::experiments
