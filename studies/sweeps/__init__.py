"""Studies: many cases declared as data, each run once and kept on disk.

study: what is declared. scenes: the scenes of a study, on any grid. case: one case and its key.
code: which code computes it. store: finished cases as files. work: what runs in a worker. engines:
where workers are. runner: all together. table: the cases as one data set. What a case computes
is a kind, see studies.kinds.
"""
