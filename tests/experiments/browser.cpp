#include "browser.h"

#include <fstream>

namespace raylex::test {

bool has_browser(const Folder& folder) {
    return run_shell(folder, "command -v chromium").code == 0;
}

// Not --dump-dom, which waits for the page's load event or for a virtual clock that runs ahead of the threads that
// unpack pictures and make frames. A script added to a copy of the page reports when everything has loaded.
Outcome in_browser(const Folder& folder, const std::string& page, const std::string& size,
                   const std::vector<std::string>& selectors) {
    std::string wanted;
    for (const std::string& selector : selectors) wanted += (wanted.empty() ? "'" : ", '") + selector + "'";
    std::ofstream(folder.path("watched.html")) << folder.read(page)
                                               << "<script>\n"
                                                  "const watch = setInterval(() => {\n"
                                                  "  if (!["
                                               << wanted
                                               << "].every(each => document.querySelector(each))) return;\n"
                                                  "  clearInterval(watch);\n"
                                                  "  const copy = document.documentElement.cloneNode(true);\n"
                                                  "  copy.querySelectorAll('script').forEach(each => each.remove());\n"
                                                  "  console.log('<<<document ' + copy.outerHTML + ' document>>>');\n"
                                                  "}, 50);\n"
                                                  "</script>\n";
    // A browser that does not start on a busy machine is not the subject of the test, so another one is started.
    Outcome outcome = run_shell(folder,
                                "for start in 1 2 3; do\n"
                                "  chromium --headless --no-sandbox --disable-gpu --disable-dev-shm-usage "
                                "--user-data-dir=\"$PWD/browser$start\""
                                " --enable-logging=stderr --window-size=" +
                                    size +
                                    " --remote-debugging-port=0 \"file://$PWD/watched.html\" 2>said &\n"
                                    "  for _ in $(seq 600); do grep -q 'document>>>' said && break; sleep 0.1; done\n"
                                    "  kill $!; wait $!\n"
                                    "  cat said >&2\n"
                                    "  grep -q 'document>>>' said && break\n"
                                    "done\n"
                                    "exit 0");
    const std::size_t begin = outcome.err.find("<<<document "), end = outcome.err.find(" document>>>");
    if (begin != std::string::npos && end != std::string::npos) outcome.out = outcome.err.substr(begin, end - begin);
    return outcome;
}

}  // namespace raylex::test
