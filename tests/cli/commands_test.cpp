// --commands, raylex submit and raylex status: commands are independent and repeatable, and give the bits of a single
// run; impossible requests are refused.
#include <catch2/catch.hpp>

#include <sstream>

#include "experiments/cluster/command_plan.h"
#include "experiments/job/text/json.h"
#include "support.h"
#include "tests/support/skip.h"

using namespace raylex::test;
using raylex::experiments::Json;
using raylex::experiments::parse_json;

namespace {

Outcome done(const Folder& folder, const std::string& line) {
    Outcome outcome = run_shell(folder, line);
    INFO(line << "\n" << outcome.out << outcome.err);
    REQUIRE(outcome.code == 0);
    return outcome;
}

bool has_tool(const Folder& folder, const std::string& tool) {
    return run_shell(folder, "command -v " + tool).code == 0;
}

struct StudyFolder : SceneFolder {
    StudyFolder() {
        write("c.toml", R"(name = "a study"
replicates = 3
threads = 2
[[scene]]
name = "room"
file = "room.pbrt"
[[method]]
name = "path"
[budget]
samples = [16, 48]
[reference]
method = "path"
spp = 32
[[channel]]
name = "direct"
lpe = "CDL"
)");
    }
    /// Returns the numbers of all cells in a results directory.
    [[nodiscard]] std::string bits(const std::string& results) const {
        return run_shell(*this, "cd '" + results +
                                    "/cells' && find . -name record.bin -o -name '*.npy' | sort | "
                                    "xargs sha256sum")
            .out;
    }
};

const std::string plan = "\"$RAYLEX\" experiment plan c.toml -o all --no-calibration ";

}  // namespace

TEST_CASE("the commands of a render are independent, and running them twice gives the bits of one render", "[gate]") {
    const SceneFolder folder;
    folder.write("it's a job.toml", "[scene]\nfile = \"room.pbrt\"\n[render]\nspp = 48\n");
    const std::string render = "render \"it's a job.toml\" --lpe \"direct=C<RD>L\" --threads 2";
    done(folder, "exec \"$RAYLEX\" " + render + " -o whole.exr");
    const Outcome printed =
        done(folder, "exec \"$RAYLEX\" " + render + " -o out.exr --preview p.png --shards 3 --commands");
    CHECK(printed.out.find(folder.path("out.exr")) != std::string::npos);
    CHECK(count_matches(printed.out, "--shard [123]/3  # shard-[123]-of-3: [0-9.]+ [kMG]B, [^\n]* CPU, 2 cores\n") ==
          3);
    CHECK(contains(printed.out, "previews, viewers and statistics are left out"));
    folder.write("commands", printed.out);
    CHECK_FALSE(folder.has("out.exr"));
    // From any folder, and a second time.
    for (int i = 0; i < 2; ++i) {
        const Outcome run = done(folder, "cd / && sh '" + folder.path("commands") + "'");
        CHECK((count_matches(run.out, "is done already") == (i == 0 ? 0 : 3)));
        CHECK((image_bits(folder.path("out.exr")) == image_bits(folder.path("whole.exr"))));
    }
    // In parallel, like xargs and GNU parallel: the merge waits for the others.
    done(folder, "rm out.exr*; xargs -P 4 -d '\\n' -n 1 sh -c < commands");
    CHECK((image_bits(folder.path("out.exr")) == image_bits(folder.path("whole.exr"))));
    const Outcome again = run_shell(folder, "rm out.exr.shard-2-of-3; tail -n 1 commands | sh");
    CHECK(again.code == 2);
    CHECK(contains(again.err, "out.exr.shard-2-of-3: this file does not exist, and no process on this machine"));
}

TEST_CASE("commands as JSON have their needs") {
    const SceneFolder folder;
    const Outcome printed =
        done(folder, "exec \"$RAYLEX\" render room.pbrt --spp 64 -o out.exr --threads 2 --shards 2 --commands=json");
    std::istringstream lines(printed.out);
    std::vector<Json> commands;
    for (std::string line; std::getline(lines, line);) commands.push_back(parse_json(line));
    REQUIRE(commands.size() == 3);
    CHECK(commands[0]["name"] == "shard-1-of-2");
    CHECK(commands[1]["target"] == folder.path("out.exr.shard-2-of-2"));
    CHECK(commands[0]["cores"] == 2);
    CHECK(commands[0]["memory_bytes"].get<double>() > 1e6);
    CHECK(commands[0]["cpu_seconds"].get<double>() > 0);
    CHECK(commands[2]["needs"] == Json::array({"shard-1-of-2", "shard-2-of-2"}));
    CHECK(commands[2]["arguments"][1] == "merge");
}

TEST_CASE("impossible commands are refused, and errors in templates have a line", "[law7]") {
    const StudyFolder folder;
    const std::string render = "render room.pbrt --spp 64 --no-calibration ";
    check_refused(folder, render + "--shards 2", {"--shards without --commands"});
    check_refused(folder, render + "--commands", {"expected --shards N"});
    check_refused(folder, render + "--shards 5 --commands", {"5 shards of 64 samples per pixel; expected at most 4"});
    check_refused(folder, render + "--shards 2 --commands=mke", {"'mke' is not a format"});
    check_refused(folder, render + "--shards 2 --commands --integrator pssmlt", {"Markov chains"});
    folder.write("t.mk", "{{#commands}}\n{{comand}}\n{{/commands}}\n");
    check_refused(folder, render + "--shards 2 --commands=t.mk", {"t.mk:2", "'comand'", "did you mean 'command'?"});
    folder.write("t.mk", "{{#commands}}\n");
    check_refused(folder, render + "--shards 2 --commands=t.mk", {"t.mk", "this is not a template"});
    const std::string study = "experiment plan c.toml --no-calibration ";
    check_refused(folder, study + "--commands", {"expected -o DIR"});
    check_refused(folder, study + "--shards 2", {"--shards without --commands"});
    check_refused(folder, study + "--commands --shards 7 -o all", {"7 shards of 6 cells", "--split-cells"});
}

TEST_CASE("the commands of a study give the cells of one run, even after kills", "[law3][gate]") {
    const StudyFolder folder;
    done(folder, "exec \"$RAYLEX\" experiment run \"$PWD/c.toml\" -o local");
    folder.write("commands", done(folder, plan + "--shards 3 --split-cells 2 --commands").out);
    CHECK(contains(folder.read("commands"), "--only-references"));
    // The second shard is killed while the program loads, because its cells take only milliseconds; the merge then has
    // nothing to merge.
    CHECK(run_shell(
              folder,
              "sed -n '/only-references/p;/shard 1.3/p;/shard 3.3/p' commands | sh && sed -n '/shard 2.3/s/^/exec /p' "
              "commands > second; timeout -s KILL 0.005 sh second")
              .code == 137);
    const Outcome early = run_shell(folder, "sed 's/ --wait//' commands | tail -n 1 | sh");
    CHECK(early.code == 2);
    CHECK(contains(early.err, "parts/2/finished.json: this file does not exist"));
    CHECK_FALSE(folder.has("all/results"));
    const Outcome not_yet = run_raylex(folder, "status all");
    CHECK(not_yet.code == 1);
    CHECK(contains(not_yet.out, "shard 1: done"));
    CHECK(matches(not_yet.out, "[^]*shard 2: (stopped|missing|running)[^]*merge: missing[^]*"));
    for (int i = 0; i < 2; ++i) {
        const Outcome run = done(folder, "cd / && sh '" + folder.path("commands") + "'");
        CHECK(contains(run.out, "already done"));
        CHECK((folder.bits("all/results") == folder.bits("local")));
    }
    CHECK(folder.has("all/results/report.html"));
    CHECK(run_raylex(folder, "status all").code == 0);
    // One reference for all shards.
    CHECK(done(folder, "ls -d all/references/*/ | wc -l; ls -d all/parts/*/references 2>/dev/null | wc -l").out ==
          "1\n0\n");
}

TEST_CASE("a Makefile and a Snakefile have rules for every command, and templates for other queues exist", "[gate]") {
    const StudyFolder folder;
    const std::string makefile = done(folder, plan + "--shards 2 --commands=make").out;
    CHECK(contains(makefile, "all: merge\n"));  // the folder's name has a blank, which Make cannot express
    CHECK(contains(makefile, "shard_2_of_2: references\n\t"));
    folder.write("Makefile", makefile);
    if (has_tool(folder, "make")) {
        done(folder, "make -j 4 && make");
        CHECK(folder.has("all/results/report.html"));
    }
    const std::string snakefile = done(folder, plan + "--shards 2 --commands=snakemake").out;
    CHECK(count_matches(snakefile, "\nrule ") == 5);
    CHECK(contains(snakefile, "        \"" + folder.path("all/parts/2/finished.json") + "\",\n"));
    const std::string cue = done(folder, plan + "--shards 2 --commands=opencue").out;
    CHECK(contains(cue, "<deplayer>merge</deplayer>"));
    CHECK(contains(cue, "UNTESTED"));
    const std::string kubernetes = done(folder, plan + "--shards 2 --commands=kubernetes").out;
    CHECK(contains(kubernetes, "name: \"a-study-shard-2-of-2\""));
    CHECK(contains(kubernetes, "raylex.step: \"3\""));
    CHECK(contains(kubernetes, "UNTESTED"));
}

TEST_CASE("a cell whose process was killed has failed; a restart keeps that, and --retry runs it again",
          "[law7][gate]") {
    const StudyFolder folder;
    const std::string one = " c.toml --set replicates=1 --set budget.samples=30000 --set reference.spp=1 -o ";
    done(folder, "\"$RAYLEX\" experiment run" + one + "local");
    const Outcome killed = run_shell(folder, "\"$RAYLEX\" experiment run" + one + R"(killed --resume & program=$!
for i in $(seq 1000); do [ -e killed/cells/*.partial ] && break; sleep 0.01; done
kill -KILL $(pgrep -P $program); wait $program)");
    CAPTURE(killed.out, killed.err);
    CHECK(killed.code == 2);
    CHECK(contains(killed.out + killed.err, "SIGKILL"));
    const Outcome again = run_raylex(folder, "experiment run" + one + "killed --resume");
    CHECK(again.code == 2);
    CHECK(contains(again.out, "already done, 0 cells, 1 FAILED"));
    done(folder, "\"$RAYLEX\" experiment run" + one + "killed --resume --retry");
    CHECK((folder.bits("killed") == folder.bits("local")));
    check_refused(folder, "experiment run" + one + "other --retry", {"--retry without --resume"});
}

TEST_CASE("without a queue, submit writes files for use by hand and loses nothing", "[law7][gate]") {
    const StudyFolder folder;
    const std::string submit = "PATH=/nowhere \"$RAYLEX\" submit --slurm c.toml -o all --shards 2 --no-calibration";
    const Outcome outcome = run_shell(folder, submit);
    CHECK(outcome.code == 2);
    CHECK(contains(outcome.err, "sbatch was not found"));
    CHECK(contains(outcome.err, "sbatch --dependency=afterany:ID_OF_REFERENCES"));
    CHECK_FALSE(folder.has("all/submission.json"));
    const std::string array = folder.read("all/slurm/shards.sh");
    for (const char* line : {"#SBATCH --array=1-2\n", "#SBATCH --requeue\n", "#SBATCH --cpus-per-task=1\n"})
        CHECK(contains(array, line));
    CHECK(array.find("--exclusive") == std::string::npos);
    // As Slurm would start the tasks.
    done(folder,
         "bash all/slurm/references.sh && SLURM_ARRAY_TASK_ID=2 bash all/slurm/shards.sh && "
         "SLURM_ARRAY_TASK_ID=1 bash all/slurm/shards.sh && bash all/slurm/merge.sh");
    CHECK(run_raylex(folder, "status all").code == 0);
    // Again: only unfinished work, and a retry of failed cells.
    done(folder, R"(sed -i 's/"failed": *0/"failed": 1/' all/parts/2/finished.json)");
    CHECK(run_shell(folder, submit + " --again").code == 2);
    CHECK(contains(folder.read("all/slurm/shards.sh"), "#SBATCH --array=2\n"));
    CHECK(contains(folder.read("all/slurm/commands.txt"), " --retry\n"));
    check_refused(folder, "submit c.toml -o other --shards 2", {"expected --slurm"});
    check_refused(folder, "submit --slurm c.toml -o other", {"--shards N"});
    check_refused(folder, "status other", {"contains no study"});
    // A command that measures seconds runs alone on its machine.
    done(folder, "sed -i 's/^samples = .*/seconds = 0.1/' c.toml");
    CHECK(run_shell(folder,
                    "PATH=/nowhere \"$RAYLEX\" submit --slurm c.toml -o timed --shards 2 --no-calibration "
                    "--option=--partition=quiet")
              .code == 2);
    CHECK(contains(folder.read("timed/slurm/shards.sh"), "#SBATCH --exclusive\n"));
    CHECK(contains(folder.read("timed/slurm/shards.sh"), "#SBATCH --partition=quiet\n"));
}

TEST_CASE("after a worker is killed, GNU parallel, Make and Snakemake give the same bits", "[.full][law3]") {
    const StudyFolder folder;
    for (const char* tool : {"parallel", "make", "snakemake"})
        if (!has_tool(folder, tool)) RAYLEX_SKIP(std::string("needs the package ") + tool);
    done(folder,
         "sed -i 's/^samples = .*/samples = [4096]/' c.toml && exec \"$RAYLEX\" experiment run \"$PWD/c.toml\" -o "
         "local");
    const std::string local = folder.bits("local");
    // The folder's name is unique to this test.
    const std::string worker = "pgrep -f '" + folder.path("all/parts/2") + " '";
    const std::string kill_one = "for i in $(seq 200); do [ -n \"$(" + worker +
                                 ")\" ] && break; sleep 0.05; done; sleep 0.3; kill -KILL $(" + worker + ") || true; ";
    const auto same = [&](const std::string& queue, const std::string& format, const std::string& first,
                          const std::string& again) {
        CAPTURE(queue);
        done(folder, "rm -rf all; " + plan + "--shards 3 --commands" + format + " > commands");
        static_cast<void>(run_shell(folder, "( " + first + " ) & " + kill_one + "wait"));
        done(folder, again);
        CHECK((folder.bits("all/results") == local));
    };
    same("parallel", "", "parallel -j 4 < commands", "parallel -j 4 < commands");
    same("make", "=make", "make -k -j 4 -f commands", "make -j 4 -f commands");
    const std::string snakemake = "snakemake -q -s commands --cores 4 -d work";
    same("snakemake", "=snakemake", snakemake + " --keep-going", snakemake + " --rerun-incomplete");
}
