# SPDX-License-Identifier: Apache-2.0
import pytest

from lodestar import paths
from lodestar.errors import InputError


def test_shipped_files_are_found_by_bare_name_and_with_their_folder():
    found = paths.config_path("hard.toml")
    assert found == paths.config_path("scenarios/hard.toml")
    assert found.is_file()
    assert paths.config_path("ordinary.profile").parent.name == "routes"


def test_missing_file_is_named_with_where_it_was_looked_for():
    with pytest.raises(InputError, match=r"moon\.toml: no such file in .*config or its folders"):
        paths.config_path("moon.toml")


def test_listing_is_sorted_and_without_suffix():
    names = paths.shipped("scenarios", ".toml")
    assert names == sorted(names)
    assert "ordinary" in names
    assert paths.shipped("routes", ".toml") == []


def test_installed_configuration_goes_before_that_of_a_checkout(tmp_path, monkeypatch):
    package = tmp_path / "python" / "lodestar"
    checkout = tmp_path / "config"
    package.mkdir(parents=True)
    monkeypatch.setattr(paths, "_PACKAGE", package)
    with pytest.raises(InputError, match="the shipped configuration is missing"):
        paths.config_root()
    checkout.mkdir()
    assert paths.config_root() == checkout
    (package / "config").mkdir()
    assert paths.config_root() == package / "config"
