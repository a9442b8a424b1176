"""What the output of a check says about the program that it was run on. Red is a check that itself failed: one that was never made says
nothing, whatever the exit status."""

GREEN, RED = "green", "red"
NO_TEST, TIME_OUT, NOT_REACHED = "NO TEST", "TIME OUT", "NOT REACHED"
NO_TIME_LEFT = None  # in place of an exit status

# Of tests/hil/run.py, for each check of a stage that ended before it.
STAGE_ENDED_BEFORE = "was not reached"


def of_tests(status, output):
    """Of a Google Test program. \\return  (outcome, what there is to add)"""
    if status is NO_TIME_LEFT:
        return TIME_OUT, ""
    _, has_begun, since_last_began = output.rpartition("[ RUN      ]")
    if status == 0:
        return (GREEN if "[       OK ]" in output else NO_TEST), ""
    if "[  FAILED  ]" in output:
        return RED, ""
    # A test that broke down, and took the program with it, failed as well.
    has_ended = "[       OK ]" in since_last_began or "[  SKIPPED ]" in since_last_began
    if has_begun and not has_ended:
        return RED, ""
    return NOT_REACHED, f"exit status {status}, and no test failed"


def of_check(check, output):
    """Of STAGE.CHECK in what tests/hil/run.py says. \\return  (outcome, what there is to add)"""
    said = {}
    for line in output.splitlines():
        result, _, rest = line.partition("ok ")
        name, _, detail = rest.partition("  ")
        if result in ("", "not "):
            said[name] = (result == "", detail)
    good, detail = said.get(check, (False, STAGE_ENDED_BEFORE))
    if good:
        return GREEN, detail
    if detail == STAGE_ENDED_BEFORE:
        return NOT_REACHED, said.get(f"{check.partition('.')[0]}.runs", (False, "the stage did not run"))[1]
    return RED, detail


def of_mutation(outcome, detail, may_survive, may_not_end):
    """\\return  (the mutation's result, in capitals where something is wrong; what there is to add)"""
    if outcome == GREEN:
        return ("survived", may_survive) if may_survive else ("SURVIVED", detail)
    if outcome == TIME_OUT and may_not_end:
        return RED, may_not_end
    return outcome, detail
