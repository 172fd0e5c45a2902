"""Whole sessions on a machine of one thread, by a seed.

**What it is for.** A session has a thread that ticks, one for its sockets, one that sends, two for
the disk, and some that come and go. An order that is lost once in a thousand sessions is lost at
one place of one of these threads, while another stands at one place of its own. A test with real
threads meets that place by chance, and never again. Here chance is a number: the seed.

**The machine** (``machine``). Each thread of the product is a greenlet, of which one runs at a
time. Whatever may wait (a lock, an event, a socket, a sleep, the disk) gives the turn back to the
machine, which draws who goes on. Time does not pass: it jumps to the next deadline when nobody can
go on. So a minute of a session costs as much as its work, and the same seed gives the same bytes,
on any machine and with any hash seed.

**The seam** (``seam``). The product is not changed for this: it uses threads, time, sockets and the
disk by the names of their modules (``threading.Event``), and those names are replaced in its
modules while a session is played. Only what is listed there can be replaced; ``test_seam``
reads the product's syntax trees and refuses another clock, thread or socket.

**A script** (``script``) is all that happens to one session, as data: the exercise, its stations
with every line that they send and when, by a socket or by a serial cable (``wires``), instruments
(``instruments``) and the ships that they hear (``traffic``), what befalls the disk and the time of
day, and how each process ends: killed, without power, or by a signal. A seed draws a script. A
script can be written to a file, read back and made smaller, which a seed cannot.

**The laws** (``laws``) are what must hold whatever the script. They are looked at from outside, on
the lines and in the file, and from beside each order, by wrapping three methods of the product.

**What was reached** (``milestones``) is counted beside the laws: a law that held says nothing of a
moment that no seed came to. ``--reached`` prints how many seeds reached each, and is red where none
did. What an instructor says in a row (``SCENES``) leads to where single words seldom come.

How often each word, scene, mishap and ending is drawn follows from that table by a program
(``weights``, ``--weigh``; that of 400 seeds makes nine milestones rarer than ten seeds, where
fourteen were before). ``--explore`` goes on with other chance from where a process came for the
first time (``exploring``), in a child that has all of its memory (``forks``): the way there is not
flown again, and the bytes are those of a script that is played alone.

What goes on likes some actions, drawn anew each time, twenty times as much as others (``Dice``):
three that must come in a row seldom do where all come alike.

``chains`` has fifteen faults of three events in a row, by which both ways are compared
(``--compare``). Of the processor, the plain seeds 1 to 2,838 took 1,404 s and came through two of
them, at 124 and 1,069 s. Exploring by seed 2 came through the second of these and ten others at 23
to 137 s, so at least ten times sooner (10 to 61); by seed 1 through six at 33 to 76 s (18 to 42),
four more at 173 s (6 to 8) and two at 378 and 390 s. A mark in a replay, a jump while the disk
is full and a kill in a replay came by neither. The first of the two comes by plain seeds as soon.

**A model beside the session** (``model``) is fed by the same lines and ticks, and has tables of its
own: a law that asks the product's tables holds where these are wrong. So have ``alert_model`` (who
acknowledges and silences which alert), ``admission`` (the words by which roles come in) and
``damage`` (what the journal of a recording breaks and mends). ``mistakes`` has small faults
that it sees.

**When it was lost** (``lost``): a script that breaks a law is played up to one of its orders and on
with other chance, twenty times. The order at which breaking becomes certain is told.

**The midst of an order** (``boundaries``): ten short scripts are killed at each turn between the
arrival of their last order and its answer, and the session that goes on is compared as a whole.

**What is found** is shrunk (``shrink``): lives, stations, visits, lines and mishaps are taken away
as long as the same law is broken. What is left goes into ``tests/simulation/kept``, in a file
named after the fault, and is played again by every test run.

**Faults of one line** (``planted``) that an outsider planted and nothing found stand there with
others of their kind, each with a short script in which a law sees it.

**That it finds anything** is shown by faults put back into the product (``mutants``), each of which
has to break a law within a hundred seeds.

**A class** (``class_play``): three sessions, each a process of its own on one machine, and the sea
that tells them of each other (``trainer.classroom.one_sea``). ``class_laws`` looks where each boat
is, and judges every word that the class says. ``test_class`` puts six faults into the sea.

**What it cannot show.** Threads change places where one waits, sets, sends or takes a lock, and
nowhere else: not between two bytecodes. The disk has what was last asked for and nothing later:
not torn sectors, nor what a system writes by itself (``tests/io/test_power.py`` has these). Real
kills, signals, sockets, serial lines and pages have tests of their own.
"""
