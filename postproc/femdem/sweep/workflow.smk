# A sweep for Snakemake: a job a mesh, a job a run. Called by femdem-sweep in the folder of plan.json.
import json
import sys

plan = json.load(open("plan.json"))
mesh_of = {run["key"]: run["mesh"] for run in plan["runs"]}
JOB = f"{sys.executable} -m femdem.sweep.job"


localrules:
    all,


rule all:
    input:
        expand("runs/{key}/ended.flag", key=mesh_of),


rule mesh:
    output:
        "meshes/{key}/ended.flag",
    params:
        made_from=lambda wildcards: plan["made_from"].get(wildcards.key, ""),
    group:
        "jobs"
    shell:
        "{JOB} mesh {wildcards.key}"


rule run:
    input:
        deck="runs/{key}/deck.nml",
        mesh=lambda wildcards: [f"meshes/{m}/ended.flag" for m in [mesh_of[wildcards.key]] if m],
    output:
        "runs/{key}/ended.flag",
    params:
        made_from=lambda wildcards: plan["made_from"][wildcards.key],
    group:
        "jobs"
    shell:
        "{JOB} run {wildcards.key}"
