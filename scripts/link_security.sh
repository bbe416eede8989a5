#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# link_security.sh FOLDER NAME...: what robots need to sign and encrypt all that they send. Needs openssl.
#
# Makes in FOLDER an authority of the team (team.pem, team.key), the rules of the team, and for each robot
# NAME a certificate, its rights, and NAME.xml: settings of CycloneDDS, for CYCLONEDDS_URI=file://FOLDER/NAME.xml.
# Each robot needs NAME.key and all files that NAME.xml names; team.key signs new robots and stays at home.
# A folder that has an authority keeps it. Certificates are valid for 1 year.
set -euo pipefail

folder=$(mkdir -p "$1" && cd "$1" && pwd)
shift
plugins=$(dirname "$(ldconfig -p | awk '/libddsc\.so/ { print $NF; exit }')")/libddsc0debian
[[ -e $plugins/libdds_security_auth.so ]] || { echo "link_security.sh: no plugins of DDS Security in $plugins" >&2; exit 1; }
cd "$folder"
days=365
umask 077

key() { openssl genpkey -quiet -algorithm EC -pkeyopt ec_paramgen_curve:prime256v1 -out "$1" 2>/dev/null; }
sign() { openssl smime -sign -in "$1" -text -out "$2" -signer team.pem -inkey team.key; }

if [[ ! -e team.key ]]; then
  key team.key
  openssl req -x509 -new -key team.key -out team.pem -days $days -subj "/CN=team"
  cat > governance.xml <<'XML'
<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"
    xsi:noNamespaceSchemaLocation="https://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_governance.xsd">
  <domain_access_rules>
    <domain_rule>
      <domains><id_range><min>0</min><max>230</max></id_range></domains>
      <allow_unauthenticated_participants>false</allow_unauthenticated_participants>
      <enable_join_access_control>true</enable_join_access_control>
      <discovery_protection_kind>ENCRYPT</discovery_protection_kind>
      <liveliness_protection_kind>SIGN</liveliness_protection_kind>
      <rtps_protection_kind>NONE</rtps_protection_kind>
      <topic_access_rules>
        <topic_rule>
          <topic_expression>*</topic_expression>
          <enable_discovery_protection>true</enable_discovery_protection>
          <enable_liveliness_protection>true</enable_liveliness_protection>
          <enable_read_access_control>true</enable_read_access_control>
          <enable_write_access_control>true</enable_write_access_control>
          <metadata_protection_kind>SIGN</metadata_protection_kind>
          <data_protection_kind>ENCRYPT</data_protection_kind>
        </topic_rule>
      </topic_access_rules>
    </domain_rule>
  </domain_access_rules>
</dds>
XML
  sign governance.xml governance.p7s
fi

for name in "$@"; do
  key "$name.key"
  openssl req -new -key "$name.key" -subj "/CN=$name" |
    openssl x509 -req -CA team.pem -CAkey team.key -CAcreateserial -days $days -out "$name.pem" 2>/dev/null
  cat > "$name.permissions.xml" <<XML
<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"
    xsi:noNamespaceSchemaLocation="https://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_permissions.xsd">
  <permissions>
    <grant name="$name">
      <subject_name>CN=$name</subject_name>
      <validity>
        <not_before>$(date -u -d yesterday +%FT%T)</not_before>
        <not_after>$(date -u -d "$days days" +%FT%T)</not_after>
      </validity>
      <allow_rule>
        <domains><id_range><min>0</min><max>230</max></id_range></domains>
        <publish><topics><topic>rt/mrpt_fusion/map_messages</topic></topics><partitions><partition>*</partition></partitions></publish>
        <subscribe><topics><topic>rt/mrpt_fusion/map_messages</topic></topics><partitions><partition>*</partition></partitions></subscribe>
      </allow_rule>
      <default>DENY</default>
    </grant>
  </permissions>
</dds>
XML
  sign "$name.permissions.xml" "$name.permissions.p7s"
  cat > "$name.xml" <<XML
<CycloneDDS>
  <Domain Id="any">
    <Security>
      <Authentication>
        <Library path="$plugins/libdds_security_auth.so" initFunction="init_authentication" finalizeFunction="finalize_authentication"/>
        <IdentityCA>file:$folder/team.pem</IdentityCA>
        <IdentityCertificate>file:$folder/$name.pem</IdentityCertificate>
        <PrivateKey>file:$folder/$name.key</PrivateKey>
      </Authentication>
      <AccessControl>
        <Library path="$plugins/libdds_security_ac.so" initFunction="init_access_control" finalizeFunction="finalize_access_control"/>
        <PermissionsCA>file:$folder/team.pem</PermissionsCA>
        <Governance>file:$folder/governance.p7s</Governance>
        <Permissions>file:$folder/$name.permissions.p7s</Permissions>
      </AccessControl>
      <Cryptographic>
        <Library path="$plugins/libdds_security_crypto.so" initFunction="init_crypto" finalizeFunction="finalize_crypto"/>
      </Cryptographic>
    </Security>
  </Domain>
</CycloneDDS>
XML
done
