# SPDX-License-Identifier: BSD-3-Clause
"""Checks a directory against what RO-Crate 1.1 and the profile Process Run Crate 0.5 demand ("MUST"), and against the
manifest beside it. Usage: crate.py DIR; prints each mistake on a line, and then exits with 1."""
import json
import os
import re
import sys
import urllib.parse

CRATE = "https://w3id.org/ro/crate/1.1"
PROFILE = "https://w3id.org/ro/wfrun/process/0.5"
ACTIONS = {"CreateAction", "ActivateAction", "UpdateAction"}
PROGRAMS = {"SoftwareApplication", "SoftwareSourceCode", "ComputationalWorkflow"}
TIME = re.compile(r"\d{4}-\d\d-\d\d(T\d\d:\d\d:\d\d(\.\d+)?(Z|[+-]\d\d:\d\d))?$")
mistakes = []


def expect(holds, text):
    if not holds:
        mistakes.append(text)


def as_list(value):
    return value if isinstance(value, list) else [] if value is None else [value]


def types(entity):
    return set(as_list(entity.get("@type")))


def references(value):
    return [item["@id"] for item in as_list(value) if isinstance(item, dict) and "@id" in item]


def check_entities(graph):
    seen = set()
    for entity in graph:
        name = entity.get("@id")
        expect(isinstance(name, str) and name, f"an entity has no @id: {entity}")
        expect(types(entity), f"{name}: has no @type")
        expect(name not in seen, f"{name}: stands there twice")
        seen.add(name)
        for key, value in entity.items():
            for item in as_list(value):
                if isinstance(item, dict):
                    expect(set(item) == {"@id"}, f"{name}: {key} is nested; the graph has to be flat")


def check_root(entities):
    descriptor = entities.get("ro-crate-metadata.json", {})
    expect("CreativeWork" in types(descriptor), "the descriptor is no CreativeWork")
    expect(CRATE in references(descriptor.get("conformsTo")), "the descriptor does not conform to RO-Crate 1.1")
    roots = references(descriptor.get("about"))
    expect(roots == ["./"], f"the descriptor is about {roots}, not the root")
    root = entities.get("./", {})
    expect("Dataset" in types(root), "the root is no Dataset")
    for key in ("name", "description", "datePublished", "license"):
        expect(root.get(key), f"the root has no {key}")
    expect(TIME.match(root.get("datePublished", "")), "datePublished is no date of ISO 8601")
    expect(PROFILE in references(root.get("conformsTo")), "the root does not conform to Process Run Crate 0.5")
    profile = entities.get(PROFILE, {})
    expect("CreativeWork" in types(profile) and profile.get("version") == "0.5", "the profile is not described")
    return root


def check_data(directory, entities, root):
    parts = references(root.get("hasPart"))
    expect(len(parts) == len(set(parts)), "hasPart names something twice")
    for name, entity in entities.items():
        if types(entity) & {"File", "Dataset"} and name != "./":
            expect(name in parts, f"{name}: is a data entity, and not in hasPart")
    for name in parts:
        expect(name in entities, f"{name}: is in hasPart, and not described")
        if ":" in name:
            continue
        expect(not name.startswith("/") and ".." not in name.split("/"), f"{name}: leads out of the directory")
        expect(re.fullmatch(r"[A-Za-z0-9._~/%-]+", name), f"{name}: is no address")
        path = os.path.join(directory, urllib.parse.unquote(name))
        is_directory = "Dataset" in types(entities.get(name, {}))
        expect(os.path.isdir(path) if is_directory else os.path.isfile(path), f"{name}: is not there")
        expect(is_directory == name.endswith("/"), f"{name}: a directory ends in a slash, and a file does not")


def check_actions(entities, root):
    actions = [e for e in entities.values() if types(e) & ACTIONS]
    expect(actions, "there is no action")
    for action in actions:
        name = action["@id"]
        expect(name in references(root.get("mentions")), f"{name}: the root does not mention it")
        for key in ("name", "description", "startTime"):
            expect(action.get(key), f"{name}: has no {key}")
        programs = references(action.get("instrument"))
        expect(len(programs) == 1, f"{name}: has {len(programs)} instruments")
        for program in programs:
            entity = entities.get(program, {})
            expect(types(entity) & PROGRAMS, f"{program}: is no program")
            expect(entity.get("name") and entity.get("softwareVersion"), f"{program}: has no name and version")
        for key in ("startTime", "endTime"):
            expect(TIME.match(action.get(key, "2026-01-01")), f"{name}: {key} is no time of ISO 8601")
        expect(action.get("endTime", "9") >= action.get("startTime", ""), f"{name}: ends before it starts")
        for key in ("object", "result"):
            for item in references(action.get(key)):
                expect(item in entities, f"{name}: {key} {item} is not described")
        for status in references(action.get("actionStatus")):
            expect(re.match(r"http://schema.org/(Completed|Failed|Active|Potential)ActionStatus$", status),
                   f"{name}: is {status}")
            expect(("endTime" in action) == (status.split("/")[-1] == "CompletedActionStatus"),
                   f"{name}: is {status}, and its endTime is {action.get('endTime')}")


def check_manifest(directory, entities):
    lines = [json.loads(line) for line in open(os.path.join(directory, "manifest.jsonl"), encoding="utf-8")]
    owned = set(lines[0]["owns"]) | {"manifest.jsonl"}
    for name, entity in entities.items():
        if types(entity) & {"File"} and ":" not in name:
            expect(urllib.parse.unquote(name) in owned, f"{name}: the manifest does not say that segcast made it")
    expect("ro-crate-metadata.json" in owned, "the manifest does not name the crate")
    for line in lines:
        if "video" in line:
            size = entities.get(urllib.parse.quote(line["video"]), {}).get("contentSize")
            expect(size == str(line["video_bytes"]), f"the film has {size} bytes, in the manifest {line['video_bytes']}")


def main(directory):
    with open(os.path.join(directory, "ro-crate-metadata.json"), encoding="utf-8") as stream:
        crate = json.load(stream)
    expect(f"{CRATE}/context" in as_list(crate.get("@context")), "the context is not that of RO-Crate 1.1")
    graph = crate.get("@graph", [])
    check_entities(graph)
    entities = {entity.get("@id"): entity for entity in graph}
    root = check_root(entities)
    check_data(directory, entities, root)
    check_actions(entities, root)
    if not os.path.exists(os.path.join(directory, "measurements.jsonl")):  # a study has no manifest
        check_manifest(directory, entities)
    for text in mistakes:
        print(text)
    return 1 if mistakes else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
