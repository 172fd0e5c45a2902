"""Import every module of the trainer; print those that cannot be, and how many there are."""

import importlib
import importlib.util
import pkgutil

import trainer

found = [each.name for each in pkgutil.walk_packages(trainer.__path__, "trainer.")]
for name in found:
    try:
        importlib.import_module(name)
    except ImportError as error:
        if error.name and not importlib.util.find_spec(error.name.partition(".")[0]):
            continue  # of an extra that is not installed here
        print(name, error)
print(len(found))
