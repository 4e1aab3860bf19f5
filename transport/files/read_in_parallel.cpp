#include "transport/files/read_in_parallel.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>

namespace raylex::transport {

// TBB warns about more threads than processors. Files differ too much in size for a fixed assignment to threads.
void read_in_parallel(std::size_t count, int threads, const std::function<void(std::size_t)>& read) {
    const int all = tbb::this_task_arena::max_concurrency();
    tbb::task_arena arena(threads > 0 ? std::min(threads, all) : all);
    arena.execute([&] {
        tbb::parallel_for(
            tbb::blocked_range<std::size_t>(0, count, 1),
            [&](const tbb::blocked_range<std::size_t>& range) {
                for (std::size_t i = range.begin(); i != range.end(); ++i) read(i);
            },
            tbb::simple_partitioner());
    });
}

}  // namespace raylex::transport
