/* SPDX-License-Identifier: BSD-3-Clause */
/* The table of commands. Only main.c refers to it. Code that a command calls gets the table from
 * sc_app instead, so that files call each other in one direction although `segcast help` needs it.
 */
#include "app.h"

const sc_command sc_commands[] = {
    {"render", "JOB.yaml", "make the video and the frames of a job",
     "Runs alone or under mpirun or srun. The output directory holds the video, manifest.jsonl "
     "(hashes of "
     "job, volume and frames), status.json (progress), stats.json and frames.csv (times), "
     "trace.json, report.html (the run as a page) and "
     "job.yaml (the job as resolved). A directory that holds a run is refused without --resume or "
     "--overwrite.",
     sc_cmd_render, true},
    {"check", "JOB.yaml", "say whether a job can run",
     "Reads the job file, the label table and the labels of the volume, and names every mistake "
     "with its "
     "file, its line and the nearest valid name. Draws and writes nothing.",
     sc_cmd_check, false},
    {"plan", "JOB.yaml", "estimate core hours, wall time, memory and disk of a job",
     "Prepares the volume, draws and encodes a few frames of the job itself, and computes what all "
     "of them take on a number of nodes, by the same rules as segcast render. Drawing them costs "
     "about a tenth of the job, and half a minute at most unless two frames take longer. Nothing "
     "is written.",
     sc_cmd_plan, false},
    {"calibrate", "", "measure what segcast plan needs to know of this machine, and keep it",
     "Takes a second or two. Measures copying, writing and sleeping; under mpirun or srun with two "
     "ranks or more also messages, and with two nodes the network, between rank 0 and the last "
     "rank. What is not measured is assumed. The numbers are kept in the user's cache directory "
     "($XDG_CACHE_HOME/segcast, or ~/.cache/segcast), for this processor and version; segcast plan "
     "reads them. Run it once on the machine where jobs are to run.",
     sc_cmd_calibrate, true},
    {"still", "JOB.yaml|VOLUME", "draw one frame of a job, or a volume, as PNG",
     "Draws the first frame, unless --frame or --time names another; of a volume, those of segcast "
     "orbit. Examples: segcast still heart.yaml --time 50% -o middle.png, segcast still heart.nrrd "
     "--size 4k -o heart.png",
     sc_cmd_still, false},
    {"storyboard", "JOB.yaml", "draw frames of the whole film on one sheet as PNG",
     "The pictures are small, with few rays per pixel, so that the sheet takes a second or two "
     "once "
     "the volume is prepared. Below each stand its number and its time in the film, which segcast "
     "still takes as --frame and --time.",
     sc_cmd_storyboard, false},
    {"views", "VOLUME", "draw the three regular slices beside the picture as PNG",
     "The slices are transverse, coronal and sagittal, in radiological convention (the patient's "
     "right is on the left). Example: segcast views heart.nrrd -o views.png",
     sc_cmd_views, false},
    {"orbit", "VOLUME", "make a video of a volume without a job file",
     "All tissues are shown, in the colours of the label table, while the camera turns once about "
     "them. Writes only the video, in the format that the ending of its name tells. VOLUME is a "
     "file, "
     "an OME-Zarr, or a directory of masks, one for each tissue. Example: segcast orbit heart.nrrd "
     "-o turn.mp4 --size 1080p --duration 8s",
     sc_cmd_orbit, true},
    {"info", "VOLUME", "print geometry and labels of a volume, with thickness and surface of each",
     "Has a line for each tissue: its number, voxels, share of boundary voxels, mean thickness, "
     "area "
     "of its surface, the opacity that opacity: auto gives it, and the name by which a job calls "
     "it.",
     sc_cmd_info, false},
    {"init", "VOLUME", "write a job to begin with, with all tissues of a volume",
     "The job names every tissue with its number, volume and measured thickness, by system of the "
     "body and from the head to the feet. Tissues are opaque; those that enclose and hide the "
     "others come first and are nearly transparent, or hidden. A file that exists is never "
     "replaced; -o - writes to standard output.",
     sc_cmd_init, false},
    {"prepare", "VOLUME|JOB.yaml", "prepare a volume as a file that later jobs map",
     "Preparing finds the surfaces in a volume, which takes seconds to minutes; a job whose volume "
     "is "
     "a prepared file begins at once. The file holds one strength of smoothing and one set of "
     "hidden "
     "tissues; give the job instead of the volume to get the file that fits the job.",
     sc_cmd_prepare, false},
    {"join", "DIR", "make the video of a job whose frames were drawn in slices",
     "DIR is the output directory that all runs with --slice or --frames share. The run that draws "
     "the last frame makes the video by itself; this command makes it at any later time.",
     sc_cmd_join, false},
    {"verify", "DIR", "check every frame and the video of a finished job against the manifest",
     "DIR is the output directory of segcast render. Compares the hashes of all files, and decodes "
     "the PNG files and the video. The exit code is 0 if all is right, 65 if something is changed "
     "or "
     "missing, 75 if the job is incomplete.",
     sc_cmd_verify, false},
    {"status", "DIR|JOB.yaml", "say whether the job of a directory is complete",
     "Prints one line, or JSON with --json. The exit code is 0 only if the job is complete, 75 if "
     "it "
     "is incomplete, 65 if the directory is damaged, 66 if it holds no run. Reads the manifest and "
     "the size of the video; `segcast verify` reads everything. Instead of a directory it takes "
     "the arguments of segcast render, so that a script asks with the same words: then the answer "
     "is for the directory of that job, or of the given slice or frames.",
     sc_cmd_status, false},
    {"study", "STUDY.yaml", "measure a job with different settings, ranks and threads",
     "Runs alone or under mpirun or srun, and measures with as many of the ranks as each cell of "
     "the study asks for. All cells are measured again and again, in random order, until the "
     "median "
     "of each is known exactly enough or the budget is used up. The directory holds "
     "measurements.jsonl (every measurement), cells.csv (medians, intervals, speed-up), "
     "extrap.jsonl (for Extra-P), status.json and study.yaml. A study that was stopped goes on "
     "with "
     "--resume, also with another number of ranks. docs/studies.md explains study files.",
     sc_cmd_study, true},
    {"report", "DIR...", "make the page of a run or of a study anew, or one that compares several",
     "Every segcast render and study ends with report.html in its directory; this makes it again "
     "from what "
     "the directory holds. Of several directories it writes one page with their speed, cost, "
     "phases and memory side by side.",
     sc_cmd_report, false},
    {"tables", "TABLE|VOLUME", "write a label table in the format of another program",
     "Reads the names, colours and opacities of a label table, or those in the header of a volume, "
     "and tells what the other format cannot hold. The format is told by the ending of the file "
     "that -o names (.ctbl: slicer, .csv, .tsv: bids, .xml, .gii: gifti, .json), or by --to; -o - "
     "writes to standard output.",
     sc_cmd_tables, false},
    {"path", "VOLUME", "print the centre line of a vessel, in mm, with its radius",
     "The line leads through the middle of the tissues that --tissue names: from end to end, or "
     "between the points --from and --to, which choose a branch. Prints lines "
     "x_mm,y_mm,z_mm,radius_mm, in RAS and about a voxel apart, or JSON with --json. The verb fly "
     "of a job takes its way through tissues from the same line.",
     sc_cmd_path, false},
    {"phantom", "", "write the built-in synthetic heart as a label volume",
     "The heart has 20 tissues, to try segcast without a volume of your own. Example: segcast "
     "phantom "
     "-o heart.nrrd --size 128x96x128",
     sc_cmd_phantom, false},
    {"keys", "[PREFIX]", "list the keys of a job file: type, range, default and meaning",
     "With a prefix, such as render or animation.camera, only the keys below it.", sc_cmd_keys,
     false},
    {"help", "[COMMAND]", "explain a command", NULL, sc_cmd_help, false},
    {"version", "", "print version, commit, compiler and libraries", NULL, sc_cmd_version, false},
    {0}};
