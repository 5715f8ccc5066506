/* SPDX-License-Identifier: BSD-3-Clause */
/* The table of commands. Only main.c refers to it. Code that a command calls gets the table from
 * sc_app instead, so that files call each other in one direction although `segcast help` needs it.
 */
#include "commands.h"

const sc_command sc_commands[] = {
    {"make", "orbit", "VOLUME", "make a video of a volume without a job file",
     "All tissues are shown, in the colours of the label table, while the camera turns once about "
     "them. Writes only the video, in the format that the ending of its name tells. VOLUME is a "
     "file, an OME-Zarr, or a directory of masks, one for each tissue. Example: segcast orbit "
     "heart.nrrd -o turn.mp4 --size 1080p --frames 8s",
     sc_cmd_orbit, true},
    {NULL, "render", "JOB.yaml", "make the video and the frames of a job",
     "Runs alone or under mpirun or srun. The output directory holds the video, manifest.jsonl "
     "(hashes of job, volume and frames), status.json (progress), stats.json and frames.csv "
     "(times), trace.json, report.html (the run as a page) and job.yaml (the job as resolved). A "
     "directory that holds a run is refused without --resume or --overwrite.",
     sc_cmd_render, true},
    {NULL, "still", "JOB.yaml|VOLUME", "draw one frame, a sheet of frames or views, or slices",
     "Draws the first frame as PNG, unless --frame or --time names another; of a volume, those of "
     "segcast orbit. --sheet N draws N frames of the whole film on one sheet: the pictures are "
     "small, with few rays per pixel, so that the sheet takes a second or two once the volume is "
     "prepared; below each stand its number and its time in the film, which --frame and --time "
     "take. --sheet views draws what is seen from ten places, and below each the --view that gets "
     "it; --sheet looks the same picture in each look. --sheet slices draws transverse, coronal "
     "and sagittal slices beside the picture, in radiological convention (the patient's right is "
     "on the left). Examples: segcast still heart.yaml --time 50% -o middle.png, segcast still "
     "heart.yaml --sheet 12 -o sheet.png, segcast still heart.nrrd --sheet slices --size 4k -o "
     "slices.png",
     sc_cmd_still, false},
    {"look", "info", "VOLUME", "print geometry, labels and thickness of tissues",
     "Has a line for each tissue: its number, voxels, share of boundary voxels, mean thickness, "
     "area of its surface, the opacity that opacity: auto gives it, and the name by which a job "
     "calls it.",
     sc_cmd_info, false},
    {NULL, "init", "VOLUME", "write a job to begin with, with all tissues of a volume",
     "The job names every tissue with its number, volume and measured thickness, by system of the "
     "body and from the head to the feet. Tissues are opaque; those that enclose and hide the "
     "others come first and are nearly transparent, or hidden. A file that exists is never "
     "replaced; -o - writes to standard output.",
     sc_cmd_init, false},
    {NULL, "desk", "JOB.yaml|VOLUME", "look at a job in a browser and change it by hand",
     "Prints an address for a browser on this machine, and the ssh -L line that makes it reachable "
     "from another. There the picture turns, zooms and is cut by hand, tissues are coloured, shown "
     "and hidden, and key frames of the film are set; all of it can be undone. Pictures are drawn "
     "by the same renderer as frames: when nothing moves, the picture is that of segcast still, "
     "byte for byte. What is changed are keys of the job, which is saved as a job file: comments "
     "and order of an opened file stay. Of a volume, the job is that of segcast init. The address "
     "holds a secret, without which nothing is served. Ends with Ctrl-C, or by --idle. Example: "
     "segcast desk heart.yaml --idle 60",
     sc_cmd_desk, true},
    {NULL, "convert", "VOLUME|TABLE|JOB.yaml",
     "write a mesh, prepared file, label table, line or phantom",
     "The ending of the file that -o names tells what is written. .segc: the volume, prepared. "
     "Preparing finds the surfaces, which takes seconds to minutes; a job whose volume is a "
     "prepared file begins at once. The file holds one strength of smoothing and one set of hidden "
     "tissues; give the job instead of the volume to get the file that fits the job. .glb, .3mf, "
     ".ply, .stl: the smooth surfaces that are drawn, as a closed mesh for each tissue, or for "
     "those of --tissue, in RAS mm; GLB in metres, with superior up and anterior to the front. "
     ".ctbl (slicer), .csv, .tsv (bids), .xml, .gii (gifti), .json, or the format of --to: the "
     "names, colours and opacities of a label table, or those in the header of a volume; what the "
     "format cannot hold is told. With --tissue, .csv or .json: the centre line of a vessel, "
     "through the middle of the tissues, from end to end or between the points --begin and --end, "
     "which choose a branch: x_mm,y_mm,z_mm,radius_mm, in RAS and about a voxel apart; the verb "
     "fly of a job takes its way through tissues from the same line. .nrrd, of phantom or "
     "phantom:WxDxH: the built-in synthetic heart with 20 tissues, of 469x325x487 or other voxels, "
     "to try segcast without a volume of your own. -o - writes a table or a line to standard "
     "output.",
     sc_cmd_convert, false},
    {"check", "check", "JOB.yaml", "say whether a job can run",
     "Reads the job file, the label table and the labels of the volume, and names every mistake "
     "with its file, its line and the nearest valid name. Draws and writes nothing.",
     sc_cmd_check, false},
    {NULL, "verify", "DIR", "prove every frame and the video of a finished job",
     "DIR is the output directory of segcast render. Compares the hashes of all files, and decodes "
     "the PNG files and the video; of a study, compares its crate with what its measurements say. "
     "The exit code is 0 if all is right, 65 if something is changed or missing, 75 if the job is "
     "incomplete.",
     sc_cmd_verify, false},
    {"cluster", "plan", "JOB.yaml", "estimate core hours, wall time, memory and disk of a job",
     "Prepares the volume, draws and encodes a few frames of the job itself, and computes what all "
     "of them take on a number of nodes, by the same rules as segcast render. Drawing them costs "
     "about a tenth of the job, and half a minute at most unless two frames take longer. Nothing "
     "is written. With --calibrate it takes no job, but a second or two to measure what it needs "
     "to know of this machine: copying, writing and sleeping; under mpirun or srun with two ranks "
     "or more also messages, and with two nodes the network, between rank 0 and the last rank. "
     "What is not measured is assumed. The numbers are kept in the user's cache directory "
     "($XDG_CACHE_HOME/segcast, or ~/.cache/segcast), for this processor and version. Calibrate "
     "once on the machine where jobs are to run.",
     sc_cmd_plan, false},
    {NULL, "status", "DIR|JOB.yaml", "say whether the job of a directory is complete",
     "Prints one line, or JSON with --json. The exit code is 0 only if the job is complete, 75 if "
     "it is incomplete, 65 if the directory is damaged, 66 if it holds no run. Reads the manifest "
     "and the size of the video; `segcast verify` reads everything. Instead of a directory it "
     "takes the arguments of segcast render, so that a script asks with the same words: then the "
     "answer is for the directory of that job, or of the given slice or frames.",
     sc_cmd_status, false},
    {NULL, "join", "DIR", "make the video of a job that was drawn in slices",
     "DIR is the output directory that all runs with --slice or --frames share. The run that draws "
     "the last frame makes the video by itself; this command makes it at any later time.",
     sc_cmd_join, false},
    {"measure", "study", "STUDY.yaml", "measure a job with different settings, ranks and threads",
     "Runs alone or under mpirun or srun, and measures with as many of the ranks as each cell of "
     "the study asks for. All cells are measured again and again, in random order, until the "
     "median of each is known exactly enough or the budget is used up. The directory holds "
     "measurements.jsonl (every measurement), cells.csv (medians, intervals, speed-up), "
     "extrap.jsonl (for Extra-P), status.json and study.yaml. A study that was stopped goes on "
     "with --resume, also with another number of ranks. docs/studies.md explains study files.",
     sc_cmd_study, true},
    {NULL, "report", "DIR...", "make the page of a run or study, or of several",
     "Every segcast render and study ends with report.html in its directory; this makes it again "
     "from what the directory holds. Of several directories it writes one page with their speed, "
     "cost, phases and memory side by side.",
     sc_cmd_report, false},
    {"help", "help", "[COMMAND|keys [PREFIX]|cache]",
     "explain a command, or list the keys of a job file",
     "segcast help keys lists type, range, default and meaning of the keys of a job file; with a "
     "prefix, such as render or animation.camera, only those below it. segcast help cache says "
     "where prepared volumes are kept for the next command, and how much of them.",
     sc_cmd_help, false},
    {0}};
