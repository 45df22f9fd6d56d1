"""The commands.

=========== ================================================================
file        holds
=========== ================================================================
main        ``vrlf``: the group, and how errors become one line
options     options that several commands share: the rig, the device
sources     what can stand where a command wants a SOURCE
pictures    ``prefilter``, ``perceive``, ``chart``
comparing   ``compare``: how like two pictures are
previewing  ``preview``: the live window
preview/    what the window is made of
rendering   ``render``: its frames without it
encoder     a picture on the GPU as the codes that files hold
eyes        ``eye``: what each eye makes of a point
facts       ``inspect``, ``rigs``, ``doctor``
lenslets    ``lenslet``: how well the array's lenslets focus
lenslet_words the text of that
designing   ``design``: the array that serves an eye best
masking     ``mask``: it drawn at true scale
profiles    ``profile``: a viewer's code as a rig
words       the text of ``inspect``
evaluating  ``evaluate``: numbers, pictures and a report for many sources and rigs
demo        ``demo``: the whole chain on shipped content
sheet       the demo's one picture of all of it
benching    ``bench``, ``bench speed``
judging     ``bench quality``, ``bench frames``
running     ``bench change``, ``bench memory``
tolerating  ``bench tolerance``
reproducing ``reproduce``: the thesis's results beside ours
sweeping    ``sweep``: many rigs, sources and methods on many workers
sizes       what the benches' options turn text into
=========== ================================================================
"""
